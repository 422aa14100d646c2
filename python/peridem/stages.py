"""Scenes in stages: what one run has brought about is where the next one begins.

::

    bed = Scene(title="Settling", ..., adapt="eta 1e9", rest=1e-3)
    run.run(bed.write("out/bed"))
    press = bed.after("out/bed", title="Pressing", walls=[*bed.walls, lid], duration=5e-3)
    run.run(press.write("out/press"))

The second script reads the restart file that the first one has left: positions, velocities, broken
bonds and what contacts remember are there to the bit, time goes on.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from peridem.regions import Rotation
from peridem.run_restart import newest_restart
from peridem.run_script import broken_bonds
from peridem.walls import AnyWall, Wall

if TYPE_CHECKING:
    from peridem.results_dump import Frame
    from peridem.results_output import Output
    from peridem.scene import Grain, Scene

Array = NDArray[np.float64]
START = "start.restart"  # the state, beside the script that begins with it


@dataclass(frozen=True)
class Beginning:
    """The state that a scene begins with.

    Attributes:
        restart: LAMMPS's file.
        title: of the run that has left it.
        step: of that run at its end.
        moved: how far its walls had moved since their points were said, by their names.
        sides: of its simulation box, as ``boundary`` has them; none if they are not known.
        box: low and high side of it in each direction.
    """

    restart: Path
    title: str
    step: int
    moved: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    sides: tuple[str, ...] = ()
    box: tuple[tuple[float, float], ...] = ()

    def shift(self, wall: AnyWall) -> Array:
        """How far a wall is from its point at the beginning, (d,)."""
        return np.array(self.moved.get(wall.name, (0.0,) * len(wall.velocity)))


def after(scene: Scene, path: str | Path, **changes: Any) -> Scene:
    """See :meth:`peridem.scene.Scene.after`."""
    from peridem.results_output import Output

    if "grains" in changes:
        raise ValueError("scene: its grains are those of the run it begins with")
    path = Path(path)
    folder, restart = _restart(path)
    output = Output(folder)
    file, step = newest_restart([restart])
    time = _time(output, step)
    frame = _frame(output, step)
    grains = _grains(scene, output, frame)
    sides, box = _sides(output), tuple((low, high) for low, high in frame.box.tolist())
    begin = Beginning(file.resolve(), output.title, step, _moved(output, time), sides, box)
    walls = [_placed(wall, begin, output, time) for wall in changes.pop("walls", scene.walls)]
    made = replace(
        scene, **({"start_time": time} | changes), grains=grains, walls=walls, begin=begin
    )
    _check_bonds(made, output)
    return made


def _restart(path: Path) -> tuple[Path, Path]:
    """The folder of a run, and its restart file."""
    from peridem.scene import RESTART

    if path.is_file():
        return path.parent, path
    if not path.is_dir():
        raise FileNotFoundError(f"no folder or restart file {path}")
    if not (path / RESTART).is_file():
        raise FileNotFoundError(f"no {RESTART} in {path}: has its run ended?")
    return path, path / RESTART


def _time(output: Output, step: int) -> float:
    table = output.thermo
    if "Time" not in table or not (table["Step"] == step).any():
        raise ValueError(
            f"{output.folder}: the log does not tell the time of the restart file's step {step}"
        )
    return float(table["Time"][table["Step"] == step][-1])


def _frame(output: Output, step: int) -> Frame:
    """The last dump before the restart file was written."""
    last = int(np.searchsorted(output.dump.steps, step, side="right")) - 1
    if last < 0:
        raise ValueError(f"{output.dump.path}: no frame up to step {step} of the restart file")
    return output.frame(last)


def _sides(output: Output) -> tuple[str, ...]:
    if "sides" in output.summary:
        return tuple(output.summary["sides"])
    said = re.search(r"^\s*boundary((?:\s+[pfsm]{1,2}){3})", output.script, re.MULTILINE)
    return tuple(said[1].split()) if said else ()


def _grains(scene: Scene, output: Output, frame: Frame) -> list[Grain]:
    """The grains where a dump shows them."""
    known, mine = output.reference, scene.reference
    if known.shape != mine.shape or not np.allclose(known, mine, rtol=1e-9, atol=1e-15):
        raise ValueError(
            f"scene: its {len(scene.grains)} grains of {len(mine)} nodes are not those of "
            f"{output.folder} ({len(known)} nodes)"
        )
    if "type" in frame and (frame["type"] != scene.type_of_node).any():
        raise ValueError(f"scene: its materials are not those of {output.folder}")
    moved = frame.position[:, : scene.dimension] - mine
    speed = frame.velocity[:, : scene.dimension] if "vx" in frame else np.zeros_like(moved)
    found, first = [], 0
    for grain in scene.grains:
        rows = slice(first, first + len(grain.cloud.nodes))
        found.append(replace(grain, displacement=moved[rows], velocity=speed[rows]))
        first = rows.stop
    return found


def _moved(output: Output, time: float) -> dict[str, tuple[float, ...]]:
    """How far the walls of a run have moved, planes and regions."""
    origins = {wall["name"]: wall for wall in output.known_walls}
    moved = {}
    for wall in output.walls(time):
        origin = origins[wall.name].get("origin", origins[wall.name]["point"])
        moved[wall.name] = wall.point - np.array(origin)[: output.dimension]
    for region in output.regions(time):
        moved[region.name] = region.shift
    return {name: tuple(way.tolist()) for name, way in moved.items() if way.any()}


def _placed(wall: AnyWall, begin: Beginning, output: Output, time: float) -> AnyWall:
    """A wall of the new scene, turned on from where it is."""
    if isinstance(wall, Wall):
        before = {other["name"]: other for other in output.known_walls}.get(wall.name, {})
        origin = np.array(before.get("origin", before.get("point", wall.point)))[: len(wall.point)]
        if wall.name in begin.moved and not np.allclose(origin, wall.point, rtol=1e-9, atol=1e-15):
            raise ValueError(
                f"scene: wall '{wall.name}' goes on from where it is, "
                f"{begin.moved[wall.name]} from its point {tuple(origin.tolist())}: leave it there "
                "or give the wall another name"
            )
        return wall
    turned, words = _turned(output, wall.name, time)
    if wall.rotation is not None:
        return replace(wall, rotation=replace(wall.rotation, start=time, turned=turned))
    if not turned:
        return wall
    at = tuple(float(word) for word in words)  # it turns no more, and stays as it is
    still = Rotation(0.0, at[:3], (at[3], at[4], at[5]), turned=turned)
    return replace(wall, rotation=still)


def _turned(output: Output, name: str, time: float) -> tuple[float, list[str]]:
    """How far a region of a script has turned at some time; point and axis of its rotation."""
    number = r"([-+.\deE]+)"
    formula = rf"{number}\*(?:time|\(time-{number}\))(?:\+{number})?"
    said = re.search(rf"^variable\s+{name}_angle\s+equal\s+{formula}$", output.script, re.M)
    about = re.search(rf"\brotate\s+v_{name}_angle((?:\s+{number}){{6}})", output.script)
    if not (said and about):
        return 0.0, []
    rate, start, turned = (float(value or 0.0) for value in said.groups())
    return rate * (time - start) + turned, about[1].split()


def _check_bonds(scene: Scene, output: Output) -> None:
    """Families are found again under the ID of their fix."""
    mine, known = broken_bonds(scene.script()), broken_bonds(output.script)
    if mine is not None and known is not None and mine != known:
        raise ValueError(
            f"scene: its bonds are '{mine}', in {output.folder} '{known}': cuts and unbroken bonds "
            "must be said in the first stage already"
        )


def box_changes(scene: Scene) -> list[str]:
    """The commands that change the box of the restart file, where it would not do.

    A side that follows the nodes does for any scene.
    """
    begin = scene.begin
    if begin is None or not _too_small(scene, begin):
        return []
    low, high = scene.corners()
    ends = [
        f"{axis} final {low[k]:.10g} {high[k]:.10g}"
        for k, axis in enumerate("xyz"[: scene.dimension])
        if scene.sides[k] != "p"
    ]
    return [
        "# the box of the restart file does not do here; it may be changed after a run only",
        "run             0 post no",
        f"change_box      all boundary {' '.join(scene.sides)} {' '.join(ends)} units box",
    ]


def sides(scene: Scene) -> list[str]:
    """The sides that the box has in the run of a scene."""
    if scene.begin is None or not scene.begin.sides or _too_small(scene, scene.begin):
        return scene.sides
    return list(scene.begin.sides)


def _too_small(scene: Scene, begin: Beginning) -> bool:
    if not begin.sides:
        return True
    low, high = scene.corners()
    for k in range(scene.dimension):
        old, new = (text[:1] + text[-1:] for text in (begin.sides[k], scene.sides[k]))
        beyond = (low[k] < begin.box[k][0], high[k] > begin.box[k][1])
        if any(a == "f" and (b != "f" or out) for a, b, out in zip(old, new, beyond, strict=True)):
            return True
    return False
