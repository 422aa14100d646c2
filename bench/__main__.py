"""``python -m bench``: measure, write csv files, pictures and the page.

python -m bench                    all parts, into bench/results and doc/performance.md
python -m bench adapt series       adaptive grains: twenty minutes of it
python -m bench kernels scenes     these parts anew, the others as they were measured before
python -m bench --quick --output out/bench     small sizes, to try it (a minute)
"""

from __future__ import annotations

import sys

from bench import adapt, command, grains, kernels, levels, memory, ranks, scenes, series, setup

PARTS = {
    "kernels": kernels,
    "scenes": scenes,
    "levels": levels,
    "grains": grains,
    "ranks": ranks,
    "memory": memory,
    "setup": setup,
    "adapt": adapt,
    "series": series,
}

if __name__ == "__main__":
    sys.exit(command.main(PARTS, "python -m bench", __doc__ or ""))
