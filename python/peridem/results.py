"""What LAMMPS wrote, as numpy arrays: dumps, thermo output, averages.

Files are read when they are asked for, a dump one frame at a time; it may be compressed (``.gz``).
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Frame:
    """One time of a dump.

    Attributes:
        step: time step number.
        box: (3, 2) low and high sides of the simulation box.
        columns: name → (n,) values, in the order of the atom IDs.
    """

    step: int
    box: Array
    columns: dict[str, Array]

    def __getitem__(self, column: str) -> Array:
        if column not in self.columns:
            raise KeyError(f"no column '{column}' in the dump; it has {', '.join(self.columns)}")
        return self.columns[column]

    @property
    def position(self) -> Array:
        """Positions, (n, 2), or (n, 3) if the dump has z."""
        return np.column_stack([self[k] for k in "xyz" if k in self.columns or k != "z"])


class Dump:
    """A file of ``dump custom``: frames by number, read lazily.

    ``len(dump)``, ``dump[0]``, ``dump[-1]``, ``dump.steps`` and a loop over it work. A last frame
    that is still being written is left out.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a text dump.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if not self.path.is_file():
            raise FileNotFoundError(f"no dump file {self.path}")
        self._offsets, self._steps = self._scan()

    def _open(self) -> IO[bytes]:
        if self.path.suffix == ".gz":
            return gzip.open(self.path, "rb")  # type: ignore[return-value]
        return self.path.open("rb")

    def _scan(self) -> tuple[list[int], list[int]]:
        """Where each whole frame starts in the file, and its step."""
        offsets, steps = [], []
        with self._open() as file:
            while True:
                start = file.tell()
                line = file.readline()
                if not line:
                    break
                if line.strip() != b"ITEM: TIMESTEP":
                    raise ValueError(
                        f"{self.path} is not a text dump: '{_shown(line)}' at byte {start} "
                        "instead of 'ITEM: TIMESTEP'"
                    )
                try:
                    step = int(file.readline())
                    file.readline()
                    count = int(file.readline())
                except ValueError:
                    break  # cut off here
                for _ in range(5 + count):
                    line = file.readline()
                if not line.endswith(b"\n"):
                    break
                offsets.append(start)
                steps.append(step)
        return offsets, steps

    @property
    def steps(self) -> NDArray[np.int64]:
        """Time step numbers of the frames."""
        return np.array(self._steps, dtype=np.int64)

    def __len__(self) -> int:
        return len(self._steps)

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, i: int) -> Frame:
        if not -len(self) <= i < len(self):
            raise IndexError(f"frame {i} of {len(self)} in {self.path}")
        with self._open() as file:
            file.seek(self._offsets[i])
            head = [file.readline() for _ in range(9)]
            count = int(head[3])
            names = head[8].decode().split()[2:]
            rows = np.loadtxt(file, max_rows=count, ndmin=2) if count else np.empty((0, len(names)))
        box = np.array([[float(v) for v in line.split()[:2]] for line in head[5:8]])
        if "id" in names:
            rows = rows[np.argsort(rows[:, names.index("id")], kind="stable")]
        return Frame(self._steps[i], box, dict(zip(names, rows.T.copy(), strict=True)))

    def nearest(self, step: int) -> int:
        """Number of the frame nearest to a time step."""
        return int(np.abs(self.steps - step).argmin())


def thermo(path: str | Path) -> dict[str, Array]:
    """Thermo output of a log file: column heading → values; the runs of a log one after another.

    A step that ends one run and starts the next appears once.

    Raises:
        ValueError: there is none, or runs have different columns.
    """
    names: list[str] = []
    rows: list[list[float]] = []
    inside = False
    for line in Path(path).read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            if names and words != names:
                raise ValueError(f"{path}: runs with different thermo columns: {names} and {words}")
            names, inside = words, True
        elif inside and line.startswith("Loop time"):
            inside = False
        elif inside and len(words) == len(names):
            try:
                row = [float(word) for word in words]
            except ValueError:
                continue  # a warning among the numbers
            if rows and row[0] == rows[-1][0]:
                rows.pop()
            rows.append(row)
    if not names:
        raise ValueError(f"{path} has no thermo output")
    return dict(zip(names, np.array(rows).reshape(-1, len(names)).T, strict=True))


def averages(path: str | Path) -> dict[str, Array]:
    """A file of ``fix ave/time`` with scalar values: column name → (n,) values.

    Raises:
        ValueError: no second comment line naming the columns.
    """
    with Path(path).open() as file:
        file.readline()
        names = file.readline().lstrip("#").split()
    if not names:
        raise ValueError(f"{path} is no output of fix ave/time")
    rows = np.loadtxt(path, ndmin=2)
    return dict(zip(names, rows.reshape(-1, len(names)).T, strict=True))


def per_grain(frame: Frame, values: Array | None = None) -> tuple[NDArray[np.int64], Array]:
    """Means over the nodes of each grain.

    Args:
        frame: with the column ``mol``.
        values: (n,) or (n, k), one row for each atom; None: the positions.

    Returns:
        The molecule-IDs, (g,), and the means, (g,) or (g, k).
    """
    grains, member = np.unique(frame["mol"].astype(np.int64), return_inverse=True)
    data = frame.position if values is None else np.asarray(values, dtype=float)
    total = np.zeros((len(grains), *data.shape[1:]))
    np.add.at(total, member, data)
    count = np.bincount(member).astype(float)
    return grains, total / count.reshape(-1, *[1] * (data.ndim - 1))


def _shown(line: bytes) -> str:
    return line[:40].decode(errors="replace").strip()
