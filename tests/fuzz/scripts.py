"""Random input scripts and data files, mostly wrong, and what LAMMPS makes of them.

A good scene is mutated: numbers become extreme or no numbers, words are dropped, doubled, swapped
or taken from other commands, lines vanish or change places, data files are cut short or garbled.
Only commands of the package and data files are touched: LAMMPS's own commands are its own.

Every outcome but two is a fault: an error message, or a run whose numbers are finite.
"""

from __future__ import annotations

import os
import random
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

SCENE = """\
units lj
dimension {dimension}
newton {newton}
boundary {boundary}
atom_style peridem{reference}
neighbor 0.3 bin
read_data nodes.data
{body}
fix motion all nve
timestep {dt}
thermo 5
thermo_modify norm no lost error
run 10
write_restart cut.restart
write_data out.data
run 10
"""
SOLIDS = (
    "pair_coeff * * {lps}bulk 30 shear 18 horizon 2.1 s0 0.05",
    "pair_coeff * * {lps}young 40 poisson 0.25 horizon 2.1 gc 0.1 influence gaussian 0.5",
    "pair_coeff * * {lps}bulk 30 shear 18 horizon 2.1 unbreakable viscosity 0.1 volume full",
    "pair_coeff 1 1 {lps}bulk 30 poisson 0.2 horizon 2.1 s0 0.1 break both influence constant",
)
CONTACTS = (
    "pair_coeff * * peridem/contact radius 0.95 stiffness 300 damping 0.5 friction 0.3",
    "pair_coeff * * peridem/contact restitution 0.7 friction 0.3",
    "pair_coeff * * peridem/contact radius auto 0.9 form bulk 2 tangential history 0.7",
    "pair_coeff * * peridem/contact modulus 20 form jha2021 horizon 2 fragments no",
    "pair_coeff * * peridem/contact friction 0.5 tangential regularised 0.2",
)
OTHERS = (
    "fix floor all peridem/wall plane 0 -4 0 0 1 0 friction 0.5",
    "fix lid all peridem/wall plane 0 4 0 0 -1 0 velocity 0 -0.1 0 radius 0.95 stiffness 300",
    "region pot block -8 8 -8 8 -8 8\nfix pot all peridem/wall region pot restitution 0.5",
    "variable up equal 0.1*time\nfix lift all peridem/wall plane 0 -5 0 0 1 0 move NULL v_up NULL",
    "fix peridem_bonds all peridem/bonds cut plane 0 0 0 1 0 0 radius 2",
    "fix peridem_bonds all peridem/bonds cut segment -1 0.5 1 0.5 unbroken all",
    "fix step all peridem/timestep safety 0.5 every 5",
    "compute node all peridem/atom damage stretch dilatation energy bonds surface fragment",
    "compute books all peridem/energy\nthermo_style custom step pe ke c_books[*]",
    "compute limit all peridem/dt\nthermo_style custom step pe ke c_limit c_limit[1]",
    "fix weight all gravity 0.1 vector 0 -1 0",
)
# fmt: off
EXTREMES = [
    "0", "-0", "-1", "1", "2", "3", "0.1", "0.5", "0.5001", "0.999", "-0.999", "10", "100", "1e3",
    "1e-3", "1e-8", "-1e-8", "1e8", "1e-30", "1e30", "1e-150", "1e150", "1e-300", "1e300", "-1e300",
    "1e-320", "2147483647",
]
NO_NUMBERS = [
    "1e400", "nan", "-nan", "inf", "-inf", "3.0.1", "1e", "0x10", "1,5", "2147483648",
    "-2147483648", "9223372036854775807", "99999999999999999999", "v_none", "c_none", "f_none",
    "NULL", "*",
]
WORDS = [
    "bulk", "shear", "young", "poisson", "horizon", "gc", "s0", "unbreakable", "viscosity",
    "influence", "linear", "constant", "gaussian", "inverse", "plane", "strain", "stress", "jha",
    "volume", "taper", "full", "break", "tension", "both", "c", "potential", "pmb", "elastic",
    "rnp", "radius", "auto", "modulus", "form", "jha2021", "stiffness", "restitution", "damping",
    "friction", "tangential", "history", "regularised", "fragments", "yes", "no", "maybe", "cut",
    "segment", "region", "unbroken", "velocity", "move", "safety", "every", "damage", "stretch",
    "bonds",
    "fragment", "energy", "all", "none", "engine", "batched", "general", "sxx", "peridem/lps",
    "peridem/pmb", "peridem/contact", "lattice", "rough", "1*2", "2*1", "*2", "x", "w" * 300,
]
# fmt: on


@dataclass(frozen=True)
class Attempt:
    """An input script, its data file, and the number they come from."""

    seed: int
    script: str
    data: str


def nodes(rng: random.Random, dimension: int, reference: bool) -> str:
    """Two small blocks of nodes with different molecule-IDs, and types 1 and 2."""
    depth = 2 if dimension == 3 else 1
    rows = []
    for mol, shift in ((1, -3.0), (2, 0.2)):
        for k in range(9 * depth):
            place = (k % 3 + shift, (k // 3) % 3 - 1.0 + 0.1 * mol, float(k // 9))
            jitter = [p + 0.1 * rng.random() for p in place[:2]] + [place[2]]
            kind = 1 if rng.random() < 0.7 else 2
            row = [str(len(rows) + 1), str(mol), str(kind), "1.0", "1.5"]
            row += [f"{value:.6g}" for value in jitter]
            row += [f"{value:.6g}" for value in jitter] if reference else []
            rows.append(" ".join(row))
    speeds = [
        f"{k} {rng.gauss(0, 0.3):.4g} {rng.gauss(0, 0.3):.4g} 0"
        for k in range(1, 9 * depth * 2 + 1)
    ]
    depth_box = "-20 20" if dimension == 3 else "-0.5 0.5"
    return (
        f"nodes\n\n{len(rows)} atoms\n2 atom types\n-20 20 xlo xhi\n-20 20 ylo yhi\n"
        f"{depth_box} zlo zhi\n\nAtoms # peridem\n\n"
        + "\n".join(rows)
        + "\n\nVelocities\n\n"
        + "\n".join(speeds)
        + "\n"
    )


def body(rng: random.Random) -> list[str]:
    """Commands of the package, in a good order."""
    hybrid = rng.random() < 0.8
    lines = []
    if hybrid:
        solid = rng.choice(("peridem/lps", "peridem/lps", "peridem/pmb"))
        lines.append(f"pair_style hybrid/overlay {solid} peridem/contact")
        if solid == "peridem/pmb":
            lines.append("pair_coeff * * peridem/pmb young 40 horizon 2.1 s0 0.05")
        else:
            lines.append(rng.choice(SOLIDS).format(lps="peridem/lps "))
        lines.append(rng.choice(CONTACTS))
        if rng.random() < 0.3:
            lines.append("pair_coeff 2 2 " + rng.choice(CONTACTS).split(" ", 3)[3])
    elif rng.random() < 0.5:
        lines += ["pair_style peridem/lps", rng.choice(SOLIDS).format(lps="")]
    else:
        lines += ["pair_style peridem/contact"]
        lines += [rng.choice(CONTACTS[:1]).replace(" peridem/contact", "")]
    fixes = rng.sample(OTHERS, rng.randint(0, 4))
    return lines + [line for one in fixes for line in one.split("\n")]


def some_number(rng: random.Random) -> str:
    return rng.choice(EXTREMES if rng.random() < 0.85 else NO_NUMBERS)


def mutate_line(rng: random.Random, line: str) -> str:
    words = line.split()
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        first = min(2, len(words) - 1)
        at = rng.randrange(first, len(words))
        kind = rng.random()
        if kind < 0.7:
            numbers = [k for k in range(first, len(words)) if re.match(r"^-?[\d.]", words[k])]
            if numbers:
                words[rng.choice(numbers)] = some_number(rng)
        elif kind < 0.77:
            words[at] = rng.choice(WORDS)
        elif kind < 0.83:
            words.insert(at, rng.choice([rng.choice(WORDS), some_number(rng)]))
        elif kind < 0.88 and len(words) > 2:
            del words[at]
        elif kind < 0.95:
            words = words[: max(2, at)]
        else:
            words += words[at:]
    return " ".join(words)


def mutate_data(rng: random.Random, data: str) -> str:
    kind = rng.random()
    lines = data.split("\n")
    if kind < 0.2:
        return data[: rng.randrange(len(data))]
    if kind < 0.7:
        for _ in range(rng.choice((1, 2, 5))):
            rows = [k for k, line in enumerate(lines) if line[:1].isdigit() or line[:1] == "-"]
            words = lines[k := rng.choice(rows)].split()
            words[rng.randrange(len(words))] = some_number(rng)
            lines[k] = " ".join(words)
    elif kind < 0.8:
        del lines[rng.randrange(len(lines))]
    elif kind < 0.9:
        lines.insert(rng.randrange(len(lines)), rng.choice(lines))
    else:
        at = rng.randrange(len(data))
        return data[:at] + chr(rng.choice((0x20, 0x2D, 0x39, 0x41, 0x7F, 0x23))) + data[at + 1 :]
    return "\n".join(lines)


def attempt(seed: int) -> Attempt:
    rng = random.Random(seed)
    dimension = rng.choice((2, 2, 3))
    reference = rng.random() < 0.3
    lines = body(rng)
    what = rng.random()
    data = nodes(rng, dimension, reference)
    if what < 0.65:
        for _ in range(rng.choice((1, 1, 2, 4))):
            at = rng.randrange(rng.choice((0, 1, 1, 1)), len(lines))
            lines[at] = mutate_line(rng, lines[at])
    elif what < 0.75:
        rng.shuffle(lines)
        if rng.random() < 0.5:
            del lines[rng.randrange(len(lines))]
    else:
        data = mutate_data(rng, data)
    wraps = "p" if rng.random() < 0.2 else rng.choice("fs")
    script = SCENE.format(
        dimension=dimension,
        newton=rng.choice(("on", "off")),
        boundary=f"{wraps} f {'p' if dimension == 2 else 'f'}",
        reference=" reference" if reference else "",
        body="\n".join(lines),
        dt=rng.choice(("0.01", "0.01", "0.01", "1")),
    )
    return Attempt(seed, script, data)


# --- outcomes ------------------------------------------------------------------------------------


def run(executable: Path, script: str, folder: Path, seconds: float) -> tuple[str, str]:
    """What is wrong (empty: LAMMPS refused, or ran with finite numbers), and its output."""
    (folder / "in.fuzz").write_text(script)
    environment = dict(os.environ) | {"OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [str(executable), "-in", "in.fuzz", "-log", "none", "-nocite"],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired as late:
        return f"still running after {seconds:g} s", str(late.stdout)[-2000:]
    output = done.stdout + done.stderr
    return verdict(done.returncode, output), output


def verdict(status: int, output: str) -> str:
    """What is wrong with the way a run ended; empty if nothing is."""
    if "Sanitizer" in output or "runtime error:" in output or "Assertion '" in output:
        return "stopped by a check of memory, bounds or undefined behaviour"
    if status < 0 or status > 128:
        return f"killed by signal {abs(status)}"
    if status != 0:
        return "" if re.search(r"^ERROR", output, re.MULTILINE) else "failed without a message"
    if numbers := [line for line in thermo(output) if re.search(r"\b-?(nan|inf)\b", line)]:
        return f"ran on with {numbers[0].strip()}"
    return ""


def thermo(output: str) -> list[str]:
    """Lines of numbers between a header that begins with Step and 'Loop time'."""
    lines, inside = [], False
    for line in output.splitlines():
        if line.lstrip().startswith("Step"):
            inside = True
        elif line.startswith("Loop time"):
            inside = False
        elif inside and re.match(r"^\s*\d", line):
            lines.append(line)
    return lines
