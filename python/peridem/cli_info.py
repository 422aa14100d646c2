"""What a file or folder holds, in a few lines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from peridem import results, run_journal, run_restart
from peridem.cloud import Cloud
from peridem.results_output import Output
from peridem.run_script import total_steps

KINDS = "a folder of a run, in.NAME, .dump, .bin, .gz, .restart, log.lammps, .yaml, .py, a mesh"


def info(path: Path) -> list[str]:
    """Lines about a path.

    Raises:
        FileNotFoundError: it does not exist.
        ValueError: it is of no kind that is known.
    """
    if not path.exists():
        raise FileNotFoundError(f"no file or folder {path}")
    if path.is_dir():
        return _folder(path)
    for fits, tell in _TELLERS:
        if fits(path):
            return tell(path)
    raise ValueError(f"{path}: not of a kind that is known ({KINDS})")


def _folder(path: Path) -> list[str]:
    lines, scripts = [], sorted(path.glob("in.*"))
    if not scripts and not any(path.glob("*.dump*")) and not any(path.glob("*.bin")):
        raise FileNotFoundError(f"no run in {path.resolve()}: neither in.* nor a dump")
    for script in scripts:
        lines += _script(script)
    try:
        output = Output(path)
    except FileNotFoundError as missing:  # not run yet
        return [*lines, str(missing)]
    lines += [f"title: {output.title}", *_dump(output.dump.path)]
    if output.attributes:
        lines.append(f"fields: {', '.join(output.fields())}")
    last = len(output.dump) - 1
    lines.append(f"time: {output.time(0):g} to {output.time(last):g}")
    if "damage" in output.attributes:
        pieces = results.fragments(output, last)
        lines.append(
            f"at the end: mean damage {output.mean_damage(last):.4g}, "
            f"{len(pieces)} fragments of {len(np.unique(pieces.grain))} grains"
        )
    return lines


def _script(path: Path) -> list[str]:
    steps = total_steps(path.read_text(), path.parent)
    journal = run_journal.read(path)
    lines = [f"script: {path.name}, {f'{steps:,} steps' if steps else 'steps not known'}"]
    if journal.begun:
        done = max(journal.ended.values(), default=0)
        lines.append(
            f"run: {journal.state or 'running, or killed'}" + (f", step {done:,}" * (done > 0))
        )
    return lines


def _dump(path: Path) -> list[str]:
    dump = results.Dump(path)
    if len(dump) == 0:
        return [f"dump: {path.name}, no whole frame"]
    first = dump[0]
    return [
        f"dump: {path.name}, {len(dump)} frames, steps {dump.steps[0]:,} to {dump.steps[-1]:,}",
        f"nodes: {len(first):,}"
        + (f" in {len(np.unique(first['mol'])):,} grains" if "mol" in first else ""),
        f"columns: {', '.join(first.columns)}",
    ]


def _restart(path: Path) -> list[str]:
    return [f"restart file: {path.name}, whole, step {run_restart.restart_step(path):,}"]


def _log(path: Path) -> list[str]:
    table = results.thermo(path)
    lines = [f"log: {path.name}, {len(table['Step'])} lines, to step {int(table['Step'][-1]):,}"]
    return lines + [
        f"  {name}: {v[0]:g} to {v[-1]:g}" for name, v in table.items() if name != "Step"
    ]


def mesh_line(made: Cloud) -> str:
    """What a mesh holds."""
    what = "area" if made.dimension == 2 else "volume"
    apart = f", in {len(made.pieces)} pieces that no cell joins" if len(made.pieces) > 1 else ""
    return (
        f"{made.name}: {len(made.nodes)} nodes ({made.surface.sum()} on the boundary), "
        f"{len(made.cells)} cells, {what} {made.volumes.sum():.6g}, "
        f"smallest spacing {made.spacing:.4g}{apart}"
    )


def _mesh(path: Path) -> list[str]:
    from peridem import cloud

    return [mesh_line(cloud.read(path))]


def _source(path: Path) -> list[str]:
    from peridem import cli_source, deck

    report: list[str] = []
    if path.suffix == ".py":
        scene = cli_source.load_scene(path)
    else:
        read = deck.load(path)
        scene, report = read.scene, list(read.report)
    nodes = sum(len(grain.cloud.nodes) for grain in scene.grains)
    return [
        f"scene: {scene.title}",
        f"{scene.dimension}D, {len(scene.grains)} grains of together {nodes:,} nodes, "
        f"{len(scene.walls)} walls, {scene.duration:g} s",
        *report,
    ]


def _begins(path: Path, words: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(words)) == words


_MESHES = (".msh", ".vtu", ".stl", ".inp")
_TELLERS: tuple[tuple[Callable[[Path], bool], Callable[[Path], list[str]]], ...] = (
    (lambda p: _begins(p, run_restart.MAGIC), _restart),
    (lambda p: p.suffix in (".py", ".yaml", ".yml"), _source),
    (lambda p: p.suffix in _MESHES, _mesh),
    (lambda p: p.suffix in (".dump", ".bin", ".gz") or _begins(p, b"ITEM: "), _dump),
    (lambda p: p.name.startswith("log") or _begins(p, b"LAMMPS ("), _log),
    (lambda p: p.name.startswith("in.") or p.suffix in (".in", ".lmp"), _script),
)
