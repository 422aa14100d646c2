"""How much energy contacts gain by the length of the step: a pressed bed goes on with several.

python drift.py out/compression_502/pressed                 from its newest restart file
python drift.py out/compression_502/pressed --onset 0 --part 1.0 0.6
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from pathlib import Path

from peridem import run, scene

BOOKS = """
compute books all peridem/energy
thermo_style custom step time c_books[6] c_books[8] c_books[9]
run 0 post no
variable end equal time>=$(time+{time:.17g}:%.17g)
fix end all halt 1 v_end > 0 error continue message no
thermo 1000000
run 10000000 post no
unfix end
run 0 post no
print "work $(c_books[6]+c_books[9]:%.17g) drift $(c_books[8]:%.17g)"
"""


def script(folder: Path, part: float, onset: float | None, time: float) -> str:
    """The commands of a run that goes on from its newest restart file, with another step."""
    text = (folder / "in.grains").read_text()
    restart = max(folder.glob(f"{scene.RESTART}*"), key=lambda path: path.stat().st_mtime)
    head = text[: text.index("# ---- output")]
    head = re.sub(r"(?m)^(boundary|atom_style).*\n", "", head)
    head = re.sub(r"(?m)^read_data.*", f"read_restart {restart.resolve()}", head)
    step = re.compile(r"(?m)^(fix \S+ all peridem/timestep safety|timestep) +(\S+)")
    head, count = step.subn(lambda found: f"{found[1]} {part * float(found[2]):g}", head)
    assert count == 1, "neither timestep nor fix peridem/timestep"
    if onset is not None:
        head = re.sub(r" onset \S+", "", head)
        head = re.sub(r"(?m)^pair_coeff.* peridem/contact .*", rf"\g<0> onset {onset:g}", head)
    return head + BOOKS.format(time=time)


def main() -> int:
    """Run on with each step; print the drift of the energy beside the work of the walls."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("folder", type=Path, help="of the run of the pressed bed")
    options.add_argument(
        "--part", type=float, nargs="+", default=[1.0, 0.6, 0.3], help="of the step of that run"
    )
    options.add_argument("--onset", type=float, help="of contacts; that of the run")
    options.add_argument("--time", type=float, default=1.7e-4, help="s")
    options.add_argument("--lmp", type=Path, help="the lmp program")
    chosen = options.parse_args()
    print("part of the step  work of walls and weight     drift  drift / work")
    for part in chosen.part:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "in.drift"
            path.write_text(script(chosen.folder, part, chosen.onset, chosen.time))
            run.run(path, lmp=chosen.lmp, quiet=True)
            found = re.findall(r"(?m)^work (\S+) drift (\S+)$", (path.parent / run.LOG).read_text())
        work, drift = map(float, found[-1])
        print(f"{part:<16g} {work:25.5g} {drift:9.2g} {drift / work:13.1e}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
