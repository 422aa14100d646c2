"""Restart files: which of them are whole, which is the newest, and output trimmed to its step.

A run that goes on writes its output behind what is there. What had been written after the restart
file would then be there twice, and a last frame or line may be cut off in the middle; so files are
trimmed first: dumps to the frames before the step of the restart file, tables to the lines up to
it.
"""

from __future__ import annotations

import gzip
import os
import shutil
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from peridem.results_dump import frame_index

MAGIC = b"LammpS RestartT\0"  # opens and closes a restart file
_VERSION, _SMALLINT, _TAGINT, _BIGINT, _UNITS, _NTIMESTEP = range(6)
_IMAGEINT = 48


def restart_step(path: str | Path) -> int:
    """The time step of a binary restart file.

    Raises:
        ValueError: it is no restart file, or not a whole one.
    """
    return _header(Path(path))[1]


def restart_units(path: str | Path) -> str:
    """The system of units of a binary restart file; raises as :func:`restart_step`."""
    return _header(Path(path))[0]


def _header(path: Path) -> tuple[str, int]:
    """Units and step."""
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError(f"{path} is no restart file of LAMMPS")
        file.seek(-len(MAGIC), os.SEEK_END)
        if file.tell() < 2 * len(MAGIC) or file.read() != MAGIC:
            raise ValueError(f"{path} is not a whole restart file: its end is missing")
        file.seek(len(MAGIC))
        endian, _revision = struct.unpack("=ii", file.read(8))
        if endian != 1:
            raise ValueError(f"{path} was written on a machine with another order of bytes")
        return _records(file, path)


def _records(file: BinaryIO, path: Path) -> tuple[str, int]:
    """Reads the header's records, each a number that says which, and its value."""
    wide, units = 8, ""
    while True:
        (flag,) = struct.unpack("=i", file.read(4))
        if flag == _NTIMESTEP:
            (step,) = struct.unpack("=q" if wide == 8 else "=i", file.read(wide))
            return units, int(step)
        if flag in (_VERSION, _UNITS):
            (count,) = struct.unpack("=i", file.read(4))
            text = file.read(count).rstrip(b"\0").decode(errors="replace")
            units = text if flag == _UNITS else units
        elif flag in (_SMALLINT, _TAGINT, _BIGINT, _IMAGEINT):
            (size,) = struct.unpack("=i", file.read(4))
            wide = size if flag == _BIGINT else wide
        else:
            raise ValueError(f"{path}: the header of this restart file is of an unknown form")


def newest_restart(paths: Iterable[Path]) -> tuple[Path, int]:
    """The whole restart file with the highest step among those that exist, and its step.

    Raises:
        FileNotFoundError: none of them is whole; it says what was wrong with each.
    """
    found: list[tuple[int, Path]] = []
    wrong: list[str] = []
    names = []
    for path in paths:
        names.append(str(path))
        if not path.is_file():
            continue
        try:
            found.append((restart_step(path), path))
        except (ValueError, struct.error) as error:
            wrong.append(str(error))
    if not found:
        none = f"there is no {' or '.join(names)}" if names else "this run has written none"
        reasons = "; ".join(wrong) or none
        raise FileNotFoundError(f"no restart file to go on from: {reasons}")
    step, path = max(found, key=lambda pair: (pair[0], pair[1].stat().st_mtime))
    return path, step


def trim_dump(path: Path, step: int) -> None:
    """Leave the whole frames of a dump (text, binary, compressed) before a step; the rest goes."""
    packed = path.suffix == ".gz"
    index = [entry for entry in frame_index(path) if entry.step < step]
    end = index[-1].end if index else 0
    if not packed:
        with path.open("r+b") as file:
            file.truncate(end)
        return
    part = path.with_name(path.name + ".part")
    with gzip.open(path, "rb") as source, gzip.open(part, "wb") as target:
        left = end
        while left > 0 and (block := source.read(min(left, 1 << 20))):
            target.write(block)
            left -= len(block)
    part.replace(path)


def trim_table(path: Path, step: int) -> None:
    """Leave the records of a table up to a step, and its comments.

    A record is a line that begins with the time step, or, where a comment speaks of a
    ``Number-of-`` rows or chunks, such a line with a count and as many lines after it.
    """
    lines = path.read_text(errors="replace").splitlines(keepends=True)
    blocks = any(line.startswith("#") and "Number-of-" in line for line in lines)
    kept: list[str] = []
    at = 0
    while at < len(lines):
        words = lines[at].split()
        size = 1 + int(words[1]) if blocks and not lines[at].startswith("#") else 1
        record = lines[at : at + size]
        if len(record) < size or not record[-1].endswith("\n"):
            break  # cut off here
        if lines[at].startswith("#") or (words and float(words[0]) <= step):
            kept += record
        at += size
    part = path.with_name(path.name + ".part")
    part.write_text("".join(kept))
    part.replace(path)


def join_dump(path: Path, more: Path) -> None:
    """Append the whole frames of one dump to another of the same kind, and remove the first."""
    if not more.is_file():
        return
    if path.suffix == ".gz":
        trim_dump(more, 1 << 62)  # a cut-off last frame must not be in the middle
    else:
        index = list(frame_index(more))
        with more.open("r+b") as file:
            file.truncate(index[-1].end if index else 0)
    with path.open("ab") as target, more.open("rb") as source:
        shutil.copyfileobj(source, target)
    more.unlink()
