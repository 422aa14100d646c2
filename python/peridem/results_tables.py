"""Tables that LAMMPS writes as it runs: thermo output, averages, values by chunk or grain.

A run that was resumed writes some steps twice; those of the later run count. A last line that is
not whole is left out.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Table = dict[str, Array]


def thermo(path: str | Path) -> Table:
    """Thermo output of a log file: column heading → (n,) values; its runs one after another.

    A step that ends one run and starts the next appears once. Where runs have different columns,
    those that a run lacks are NaN. ``pandas.DataFrame(thermo(path))`` makes a data frame of it.

    Raises:
        ValueError: there is none.
    """
    steps: list[dict[str, float]] = []
    names: list[str] = []
    for line in _lines(Path(path)):
        words = line.split()
        if words[:1] == ["Step"]:
            names = words
        elif line.startswith("Loop time"):
            names = []
        elif words and len(words) == len(names):
            try:
                row = dict(zip(names, map(float, words), strict=True))
            except ValueError:
                continue  # a warning among the numbers
            while steps and steps[-1]["Step"] >= row["Step"]:
                steps.pop()
            steps.append(row)
    if not steps:
        raise ValueError(f"{path} has no thermo output that begins with Step")
    columns = list(dict.fromkeys(name for row in steps for name in row))
    return {name: np.array([row.get(name, np.nan) for row in steps]) for name in columns}


def averages(path: str | Path) -> Table:
    """A file of ``fix ave/time`` with scalar values: column name → (n,) values.

    Raises:
        ValueError: no comment line that names the columns, or the file holds vectors.
    """
    names: list[str] = []
    rows: list[list[float]] = []
    for line in _lines(Path(path)):
        if line.startswith("#"):
            words = line.lstrip("#").split()
            if words[:1] == ["TimeStep"]:
                names = words
            continue
        row = [float(word) for word in line.split()]
        if len(row) != len(names):
            break
        while rows and rows[-1][0] >= row[0]:
            rows.pop()
        rows.append(row)
    if not names:
        raise ValueError(f"{path} is no output of fix ave/time: no line names its columns")
    if any(name.startswith("Number-of-") for name in names):
        raise ValueError(f"{path} holds vectors: read it with results.vectors")
    return dict(zip(names, np.array(rows).reshape(-1, len(names)).T, strict=True))


@dataclass(frozen=True, eq=False)
class Vectors:
    """Several rows for each of several times.

    Attributes:
        steps: (t,) time steps.
        columns: name → (t, n) values; the first column numbers the rows.
    """

    steps: NDArray[np.int64]
    columns: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        if name not in self.columns:
            raise KeyError(f"no column '{name}'; there are {', '.join(self.columns)}")
        return self.columns[name]


def vectors(path: str | Path) -> Vectors:
    """A file of ``fix ave/time mode vector`` or ``fix ave/chunk``.

    Raises:
        ValueError: it is no such file, or its times have different numbers of rows.
    """
    names: list[str] = []
    times: list[tuple[int, list[list[float]]]] = []
    lines = _lines(Path(path))
    at = 0
    while at < len(lines):
        words = lines[at].lstrip("#").split()
        if lines[at].startswith("#"):
            if words[:1] in (["Row"], ["Chunk"]):
                names = words
            at += 1
            continue
        rows = [[float(w) for w in line.split()] for line in lines[at + 1 : at + 1 + int(words[1])]]
        if len(rows) < int(words[1]):
            break
        while times and times[-1][0] >= int(words[0]):
            times.pop()
        times.append((int(words[0]), rows))
        at += 1 + len(rows)
    if not names:
        raise ValueError(f"{path} is no output of fix ave/time mode vector or of fix ave/chunk")
    if len({len(rows) for _, rows in times}) > 1:
        raise ValueError(f"{path}: the number of rows changes from time to time")
    data = np.array([rows for _, rows in times]).reshape(len(times), -1, len(names))
    columns = {name: data[:, :, k] for k, name in enumerate(names)}
    return Vectors(np.array([step for step, _ in times], dtype=np.int64), columns)


def _lines(path: Path) -> list[str]:
    """The whole lines of a file, which may be compressed."""
    if not path.is_file():
        raise FileNotFoundError(f"no file {path}")
    data = path.read_bytes()
    if path.suffix == ".gz":
        data = gzip.decompress(data)
    return data[: data.rfind(b"\n") + 1].decode(errors="replace").splitlines()
