"""Scenes in stages: what one run has brought about is where the next one begins.

::

    bed = Scene(title="Settling", ..., adapt="eta 1e9", rest=1e-3)
    run.run(bed.write("out/bed"))
    press = bed.after("out/bed", title="Pressing", walls=[*bed.walls, lid], duration=5e-3)
    run.run(press.write("out/press"))

The second script reads the restart file that the first one has left: positions, velocities, broken
bonds and what contacts remember are there to the bit, time goes on. Walls go on from where they
are, unless they are put elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
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
    from peridem.loads import Motion
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
        restored: how far LAMMPS moves them from what the script says, where that is another way.
        displaced: how far bodies are put from where they had come, by the numbers of their grains.
        movers: IDs of the fixes that had moved nodes by formulas, if these start anew.
        sides: of its simulation box, as ``boundary`` has them; none if they are not known.
        box: low and high side of it in each direction.
    """

    restart: Path
    title: str
    step: int
    moved: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    restored: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    displaced: Mapping[int, tuple[float, ...]] = field(default_factory=dict)
    movers: frozenset[str] = frozenset()
    sides: tuple[str, ...] = ()
    box: tuple[tuple[float, float], ...] = ()

    def shift(self, wall: AnyWall) -> Array:
        """How far a wall is from its point at the beginning, (d,)."""
        return np.array(self.moved.get(wall.name, (0.0,) * len(wall.velocity)))

    def said(self, wall: AnyWall) -> AnyWall:
        """The wall as the script must say it, so that it is right when LAMMPS has moved it."""
        if not isinstance(wall, Wall) or wall.name not in self.restored:
            return wall
        point = np.array(wall.point) + self.shift(wall) - np.array(self.restored[wall.name])
        return replace(wall, point=tuple(point.tolist()))


@dataclass(frozen=True, eq=False)
class End:
    """The end of a run that another one may begin with.

    Attributes:
        output: of the run.
        restart: LAMMPS's file.
        step, time: when it was written.
        frame: the last dump before.
    """

    output: Output
    restart: Path
    step: int
    time: float
    frame: Frame

    @classmethod
    def of(cls, path: str | Path) -> End:
        """The end of the run in a folder, or as a restart file in it has it.

        Raises:
            FileNotFoundError: there is no restart file, or no dump.
            ValueError: the log or the dump do not reach as far.
        """
        from peridem.results_output import Output

        folder, restart = _restart(Path(path))
        file, step = newest_restart([restart])
        output = Output(folder)
        return cls(output, file.resolve(), step, _time(output, step), _frame(output, step))


def after(
    scene: Scene,
    path: str | Path,
    put: Collection[str] = (),
    bodies: Mapping[int, Sequence[float]] | None = None,
    **changes: Any,
) -> Scene:
    """See :meth:`peridem.scene.Scene.after`."""
    return begun(scene, End.of(path), put, bodies or {}, **changes)


def begun(
    scene: Scene,
    end: End,
    put: Collection[str],
    bodies: Mapping[int, Sequence[float]],
    anew: bool = False,
    **changes: Any,
) -> Scene:
    """The scene that begins with the end of a run (:meth:`peridem.scene.Scene.after`).

    Args:
        scene: with the same grains.
        end: of the run.
        put, bodies, changes: as of :meth:`peridem.scene.Scene.after`.
        anew: whether motions that follow formulas count from where the nodes are, rather than from
            where they had begun.
    """
    if "grains" in changes:
        raise ValueError("scene: its grains are those of the run it begins with")
    output, time = end.output, end.time
    walls: Sequence[AnyWall] = changes.pop("walls", scene.walls)
    unknown = sorted(set(put) - {wall.name for wall in walls})
    if unknown:
        known = ", ".join(wall.name for wall in walls) or "none"
        raise ValueError(f"scene: no wall '{unknown[0]}' to put anywhere; there are {known}")
    grains = _moved_grains(scene, output, end.frame)
    motions: Sequence[Motion] = changes.get("motions", scene.motions)
    ways = {number: _put_body(scene, grains, motions, number, to) for number, to in bodies.items()}
    moved, restored = _moved(output, time)
    begin = Beginning(
        end.restart,
        output.title,
        end.step,
        {name: way for name, way in moved.items() if name not in put},
        {name: way for name, way in restored.items() if name in put or way != moved[name]},
        {number: tuple(way.tolist()) for number, way in ways.items() if way.any()},
        _movers(output.script) if anew else frozenset(),
        _sides(output),
        tuple((low, high) for low, high in end.frame.box.tolist()),
    )
    walls = [_placed(wall, begin, output, time, wall.name in put) for wall in walls]
    made = replace(
        scene, **({"start_time": time} | changes), grains=grains, walls=walls, begin=begin
    )
    _check_bonds(made, output)
    return made


def grains_after(scene: Scene, path: str | Path) -> list[Grain]:
    """The grains of a scene where the last dump of a run of them shows them, with their velocities.

    Args:
        scene: with the same grains.
        path: the folder of the run.

    Raises:
        FileNotFoundError: there is no dump.
        ValueError: the run was one of other grains.
    """
    from peridem.results_output import Output

    output = Output(path)
    return _moved_grains(scene, output, output.frame(-1))


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


def _moved_grains(scene: Scene, output: Output, frame: Frame) -> list[Grain]:
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


def _put_body(
    scene: Scene,
    grains: list[Grain],
    motions: Sequence[Motion],
    number: int,
    to: Sequence[float],
) -> Array:
    """Put one of the grains elsewhere; returns how far that is from where it had come, (d,)."""
    if not 1 <= number <= len(grains):
        raise ValueError(f"scene: no grain {number} to put anywhere, of {len(grains)}")
    grain = grains[number - 1]
    for motion in motions:
        if number in (motion.nodes.grains or (number,)) and not motion.steady:
            raise ValueError(
                f"scene: grain {number} turns or follows formulas ('{motion.name}'): only bodies "
                "of constant velocity can be put elsewhere"
            )
    if any(material.style for material in grain.materials()):
        raise ValueError(
            f"scene: grain {number} has bonds: only bodies without bonds can be put elsewhere"
        )
    if len(to) != scene.dimension:
        raise ValueError(
            f"scene: grain {number} is put elsewhere by {scene.dimension} numbers, not {tuple(to)}"
        )
    had = grain.displacement
    assert had is not None
    way: Array = np.asarray(to, dtype=float) - had.mean(axis=0)
    size = float(np.ptp(grain.cloud.nodes, axis=0).max())
    if np.ptp(had, axis=0).max() > 1e-6 * size:  # a dump has nine digits
        raise ValueError(f"scene: grain {number} has turned or bent: it cannot be put elsewhere")
    if np.abs(way).max() < 1e-8 * size:
        way[:] = 0.0
    grains[number - 1] = replace(grain, displacement=had + way)
    return way


def _moved(
    output: Output, time: float
) -> tuple[dict[str, tuple[float, ...]], dict[str, tuple[float, ...]]]:
    """How far the walls of a run have moved, planes and regions: since their points were said; and,
    for planes, from what the script says."""
    known = {wall["name"]: wall for wall in output.known_walls}
    moved, restored = {}, {}
    for wall in output.walls(time):
        origin = known[wall.name].get("origin", known[wall.name]["point"])
        said = known[wall.name].get("said", origin)
        moved[wall.name] = wall.point - np.array(origin)[: output.dimension]
        restored[wall.name] = wall.point - np.array(said)[: output.dimension]
    for region in output.regions(time):
        moved[region.name] = region.shift
    return _tuples(moved), _tuples(restored)


def _tuples(ways: Mapping[str, Array]) -> dict[str, tuple[float, ...]]:
    return {name: tuple(way.tolist()) for name, way in ways.items()}


def _movers(script: str) -> frozenset[str]:
    """IDs of the fixes of a script that move nodes by formulas."""
    return frozenset(re.findall(r"^fix\s+(\S+)\s+\S+\s+move\b", script, re.MULTILINE))


def _placed(wall: AnyWall, begin: Beginning, output: Output, time: float, put: bool) -> AnyWall:
    """A wall of the new scene, turned on from where it is, or put elsewhere."""
    if isinstance(wall, Wall):
        before = {other["name"]: other for other in output.known_walls}.get(wall.name, {})
        origin = np.array(before.get("origin", before.get("point", wall.point)))[: len(wall.point)]
        if any(begin.shift(wall)) and not np.allclose(origin, wall.point, rtol=1e-9, atol=1e-15):
            raise ValueError(
                f"scene: wall '{wall.name}' goes on from where it is, "
                f"{begin.moved[wall.name]} from its point {tuple(origin.tolist())}: leave it "
                f"there, put it elsewhere with put=['{wall.name}'], or give it another name"
            )
        return wall
    turned, words = _turned(output, wall.name, time)
    shifts = [region.shift for region in output.regions(time) if region.name == wall.name]
    if put and (turned or np.any(shifts)):
        raise ValueError(
            f"scene: wall '{wall.name}' is a region that has moved or turned: it cannot be put "
            "elsewhere; give it another name"
        )
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


def changes_at_start(scene: Scene) -> list[str]:
    """The commands that change what the restart file holds: its box, where it would not do, and the
    places of bodies. A box whose sides follow the nodes does for any scene.
    """
    begin = scene.begin
    if begin is None:
        return []
    lines = []
    if _too_small(scene, begin):
        low, high = scene.corners()
        ends = [
            f"{axis} final {low[k]:.10g} {high[k]:.10g}"
            for k, axis in enumerate("xyz"[: scene.dimension])
            if scene.sides[k] != "p"
        ]
        lines += [
            "# the box of the restart file does not do here; it may be changed after a run only",
            "run             0 post no",
            f"change_box      all boundary {' '.join(scene.sides)} {' '.join(ends)} units box",
        ]
    if begin.displaced:
        lines += ["# bodies that start elsewhere; they may be put there after a run only"]
        lines += [] if len(lines) > 1 else ["run             0 post no"]
    for number, way in begin.displaced.items():
        name, (x, y, z) = f"put_{number}", (*way, 0.0)[:3]
        lines += [
            *emptied(scene, name),
            f"group           {name} molecule {number}",
            f"displace_atoms  {name} move {x:.12g} {y:.12g} {z:.12g} units box",
        ]
    return lines


def emptied(scene: Scene, name: str) -> list[str]:
    """What makes a group empty, if the restart file may hold one of this name."""
    if scene.begin is None:
        return []
    return [f"group           {name} empty", f"group           {name} clear"]


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
