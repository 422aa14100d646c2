"""What the numbers were measured on."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
FLAGS = ["-O3", "-march=native", "-fopenmp-simd", "-fno-math-errno", "-fno-trapping-math"]


@dataclass(frozen=True)
class Machine:
    """The processor, the programs, and what one core can do at best.

    Attributes:
        vectors: the widest that the processor has.
        memory: GB.
        bandwidth: read and written by a triad of arrays larger than the caches, GB/s.
        root_and_division: ns for one square root and one division in a vectorised loop.
    """

    processor: str
    cores: int
    vectors: str
    caches: str
    memory: int
    compiler: str
    lammps: str
    commit: str
    bandwidth: float
    root_and_division: float

    def lines(self) -> list[str]:
        """As ``key: value`` lines."""
        return [f"{key.replace('_', ' ')}: {value}" for key, value in asdict(self).items()]


def _first_line(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, cwd=HERE, check=False)
    return (done.stdout or done.stderr or "unknown").splitlines()[0].strip()


def _lscpu() -> dict[str, str]:
    done = subprocess.run(["lscpu"], capture_output=True, text=True, check=False)
    pairs = (line.split(":", 1) for line in done.stdout.splitlines() if ":" in line)
    return {key.strip(): value.strip() for key, value in pairs}


def _vectors(flags: str) -> str:
    """From what the kernel says that the processor has."""
    names = {"avx512f": "AVX-512", "avx2": "AVX2", "sve": "SVE", "asimd": "NEON"}
    return next((name for flag, name in names.items() if flag in flags.split()), "baseline")


def _limits(folder: Path) -> tuple[float, float]:
    program = folder / "limits"
    source = str(HERE / "limits.cpp")
    subprocess.run(["c++", "-std=c++17", *FLAGS, source, "-o", str(program)], check=True)
    printed = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    program.unlink()
    bandwidth, root = printed.split()
    return float(bandwidth), float(root)


def describe(lmp: Path, folder: Path) -> Machine:
    """Ask the machine; builds and runs ``limits.cpp`` in the folder."""
    cpu = _lscpu()
    caches = ", ".join(f"{key} {value}" for key, value in cpu.items() if key.startswith("L"))
    version = subprocess.run([str(lmp), "-h"], capture_output=True, text=True, check=False).stdout
    banner = next((line for line in version.splitlines() if "Massively" in line), "unknown")
    bandwidth, root = _limits(folder)
    return Machine(
        processor=cpu.get("Model name", platform.processor() or "unknown"),
        cores=int(cpu.get("CPU(s)", "1")),
        vectors=_vectors(cpu.get("Flags", "")),
        caches=caches,
        memory=round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9),
        compiler=_first_line("c++", "--version"),
        lammps=banner.split("-")[-1].strip(),
        commit=_first_line("git", "rev-parse", "--short", "HEAD"),
        bandwidth=round(bandwidth, 2),
        root_and_division=round(root, 3),
    )
