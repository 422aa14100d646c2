"""Dumps of LAMMPS, read frame by frame: text, compressed text or binary, one file or one for
each time.

LAMMPS writes a frame piece by piece. A last frame that is not whole, because the run goes on or was
cut off, is left out.
"""

from __future__ import annotations

import gzip
import os
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MAGIC = b"DUMPCUSTOM"


@dataclass(frozen=True, eq=False)
class Frame:
    """One time of a dump.

    Attributes:
        step: time step number.
        box: (3, 2) low and high sides of the simulation box.
        columns: name → (n,) values, in the order of the atom IDs.
        time: simulated time, if the dump has it (``dump_modify time yes``).
        periodic: for each direction whether the box repeats.
    """

    step: int
    box: Array
    columns: dict[str, Array]
    time: float | None = None
    periodic: tuple[bool, bool, bool] = (False, False, False)

    def __getitem__(self, column: str) -> Array:
        if column not in self.columns:
            raise KeyError(f"no column '{column}' in the dump; it has {', '.join(self.columns)}")
        return self.columns[column]

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    @property
    def position(self) -> Array:
        """Positions, (n, 2), or (n, 3) if the dump has z."""
        return np.column_stack([self[k] for k in "xyz" if k in self.columns or k != "z"])

    @property
    def velocity(self) -> Array:
        """Velocities, with as many components as positions."""
        return np.column_stack([self[f"v{k}"] for k in "xyz"[: self.position.shape[1]]])


class Entry(NamedTuple):
    """Where a whole frame lies: file, bytes from start to end (of the uncompressed text), step."""

    path: Path
    start: int
    end: int
    step: int


class Dump:
    """The frames of ``dump custom``, by number, read when they are asked for.

    ``len(dump)``, ``dump[0]``, ``dump[-1]``, ``dump.steps`` and a loop over it work. Kinds of
    files, told by their names: text, ``.bin`` (binary), ``.gz`` (compressed text); a ``*`` in the
    name stands for the time steps of as many files.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a dump.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        files = [self.path]
        if "*" in self.path.name:
            found = self.path.parent.glob(self.path.name)
            files = sorted(found, key=lambda file: _numbers(file.name))
        if not files or not files[0].is_file():
            raise FileNotFoundError(f"no dump file {self.path}")
        self._entries = [entry for file in files for entry in frame_index(file)]
        self._names: list[str] = []

    @property
    def steps(self) -> NDArray[np.int64]:
        """Time step numbers of the frames."""
        return np.array([entry.step for entry in self._entries], dtype=np.int64)

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, i: int) -> Frame:
        if not -len(self) <= i < len(self):
            raise IndexError(f"frame {i} of {len(self)} in {self.path}")
        entry = self._entries[i]
        with _open(entry.path) as file:
            file.seek(entry.start)
            read = _read_binary if _is_binary(entry.path) else _read_text
            return _in_order(read(file, entry))

    def nearest(self, step: int) -> int:
        """Number of the frame nearest to a time step."""
        if not self._entries:
            raise ValueError(f"{self.path} has no whole frame")
        return int(np.abs(self.steps - step).argmin())


def frame_index(path: Path) -> Iterator[Entry]:
    """Where each whole frame of a file starts and ends.

    Raises:
        ValueError: it is not a dump.
    """
    scan = _scan_binary if _is_binary(path) else _scan_text
    with _open(path) as file:
        try:
            yield from scan(file, path)
        except EOFError:  # a compressed file that is cut off
            return


def _numbers(name: str) -> list[int]:
    return [int(digits) for digits in re.findall(r"\d+", name)]


def _is_binary(path: Path) -> bool:
    return path.suffix == ".bin"


def _open(path: Path) -> IO[bytes]:
    if path.suffix == ".gz":
        return gzip.open(path, "rb")  # type: ignore[return-value]
    return path.open("rb")


def _in_order(frame: Frame) -> Frame:
    if "id" not in frame.columns:
        return frame
    order = np.argsort(frame["id"], kind="stable")
    if (order[1:] > order[:-1]).all():
        return frame
    columns = {name: values[order] for name, values in frame.columns.items()}
    return Frame(frame.step, frame.box, columns, frame.time, frame.periodic)


# ---- text ----------------------------------------------------------------------------------------


def _scan_text(file: IO[bytes], path: Path) -> Iterator[Entry]:
    start = 0
    while line := file.readline():
        while (
            line.startswith((b"ITEM: UNITS", b"ITEM: TIME")) and line.strip() != b"ITEM: TIMESTEP"
        ):
            file.readline()
            line = file.readline()
        if line.strip() != b"ITEM: TIMESTEP":
            if not line.endswith(b"\n") and b"ITEM: TIMESTEP".startswith(line):
                return
            shown = line[:40].decode(errors="replace").strip()
            raise ValueError(
                f"{path} is not a text dump: '{shown}' at byte {start} instead of 'ITEM: TIMESTEP'"
            )
        try:
            step = int(file.readline())
            file.readline()
            count = int(file.readline())
        except ValueError:
            return  # cut off here
        for _ in range(5 + count):
            line = file.readline()
        if not line.endswith(b"\n"):
            return
        end = file.tell()
        yield Entry(path, start, end, step)
        start = end


def _read_text(file: IO[bytes], entry: Entry) -> Frame:
    time = None
    line = file.readline()
    while line.strip() != b"ITEM: TIMESTEP":
        value = file.readline()
        if line.startswith(b"ITEM: TIME"):
            time = float(value)
        line = file.readline()
    head = [file.readline() for _ in range(8)]
    count, names = int(head[2]), head[7].decode().split()[2:]
    sides = head[3].decode().split()
    rows: Array = np.empty((0, len(names)))
    if count:
        rows = np.loadtxt(file, max_rows=count, ndmin=2)
    box = np.array([[float(v) for v in line.split()[:2]] for line in head[4:7]])
    columns = dict(zip(names, rows.T.copy(), strict=True))
    return Frame(entry.step, box, columns, time, _periodic(sides[-3:]))


def _periodic(sides: list[str]) -> tuple[bool, bool, bool]:
    x, y, z = (side == "pp" for side in sides)
    return x, y, z


# ---- binary --------------------------------------------------------------------------------------


@dataclass
class _Head:
    step: int
    box: Array
    names: list[str]
    chunks: int
    time: float | None
    periodic: tuple[bool, bool, bool]


def _scan_binary(file: IO[bytes], path: Path) -> Iterator[Entry]:
    size = path.stat().st_size
    start = 0
    while True:
        try:
            head = _binary_head(file, path)
            for _ in range(head.chunks):
                (count,) = _unpack(file, "=i")
                file.seek(8 * count, os.SEEK_CUR)
        except struct.error:
            return  # the end, or cut off here
        end = file.tell()
        if end > size:
            return
        yield Entry(path, start, end, head.step)
        start = end


def _unpack(file: IO[bytes], form: str) -> tuple[int, ...]:
    return struct.unpack(form, file.read(struct.calcsize(form)))


def _binary_head(file: IO[bytes], path: Path) -> _Head:
    (marker,) = _unpack(file, "=q")
    if marker != -len(MAGIC) or file.read(len(MAGIC)) != MAGIC:
        raise ValueError(f"{path} is not a binary dump of 'dump custom'")
    endian, revision = _unpack(file, "=ii")
    if endian != 1 or revision < 2:
        raise ValueError(f"{path}: a binary dump of another machine or an old LAMMPS")
    step, _atoms, triclinic = _unpack(file, "=qqi")
    sides = _unpack(file, "=6i")
    low_high = struct.unpack("=6d", file.read(48))
    if triclinic:
        file.read(24 if triclinic == 1 else 48)
    _unpack(file, "=i")
    (length,) = _unpack(file, "=i")
    file.read(length)  # units
    time = None
    if file.read(1) == b"\x01":
        (time,) = struct.unpack("=d", file.read(8))
    (length,) = _unpack(file, "=i")
    names = file.read(length).decode().split()
    (chunks,) = _unpack(file, "=i")
    periodic = (not sides[0], not sides[2], not sides[4])
    return _Head(step, np.array(low_high).reshape(3, 2), names, chunks, time, periodic)


def _read_binary(file: IO[bytes], entry: Entry) -> Frame:
    head = _binary_head(file, entry.path)
    pieces = []
    for _ in range(head.chunks):
        (count,) = _unpack(file, "=i")
        pieces.append(np.frombuffer(file.read(8 * count), dtype=np.float64))
    rows = np.concatenate(pieces).reshape(-1, len(head.names))
    columns = dict(zip(head.names, rows.T.copy(), strict=True))
    return Frame(head.step, head.box, columns, head.time, head.periodic)
