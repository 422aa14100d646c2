"""The state from which a deck goes on."""

from __future__ import annotations

from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.deck.sections import Model
from peridem.deck.source import Block, DeckError, Report

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class State:
    """Displacements and velocities of all nodes, (n, 3) each, and the time.

    Attributes:
        time: at which they are.
        displacement, velocity: in the order of the particles' nodes.
        counts: number of nodes of each particle.
    """

    time: float
    displacement: Array
    velocity: Array
    counts: list[int]

    def of(self, particle: int, dimension: int) -> tuple[Array, Array]:
        """Displacements and velocities of one particle's nodes, (n, d) each."""
        start = sum(self.counts[:particle])
        rows = slice(start, start + self.counts[particle])
        return self.displacement[rows, :dimension], self.velocity[rows, :dimension]


def restart(root: Block, model: Model, counts: list[int], report: Report) -> State | None:
    """The state that the section ``Restart`` names, or None.

    Raises:
        DeckError: its file is not there, or is not of these particles.
    """
    if "Restart" not in root:
        return None
    block = root.block("Restart")
    for key in block.skip("Change_Reference_Free_Dofs"):
        report.add(block.place(key), "not used, as in PeriDEM: reference positions stay")
    step = block.whole("Step")
    given = _point_data(block)
    fields = {}
    for name in ("Displacement", "Velocity"):
        if name not in given:
            raise block.error("File", f"it has no field {name}, but {', '.join(given) or 'none'}")
        values = np.asarray(given[name], dtype=float)
        fields[name] = np.pad(values, ((0, 0), (0, 3 - values.shape[1])))
        if len(values) != sum(counts):
            raise block.error(
                "File", f"it has {len(values)} nodes, the deck {sum(counts)} in {len(counts)}"
            )
    return State(step * model.dt, fields["Displacement"], fields["Velocity"], counts)


def _point_data(block: Block) -> dict[str, Any]:
    """Values of the nodes by their names."""
    name = Path(block.text("File"))
    folder = block.path.resolve().parent
    places = [folder / name, folder / name.name, folder.parent / "out" / name.name]
    places = list(dict.fromkeys(places))
    for place in places:
        for path in (place, place.with_name(place.name + ".vtu")):
            if path.is_file():
                return _read(block, path)
    looked = ", ".join(str(place) for place in places)
    raise DeckError(
        f"{block.path}:{block.place('File')[0]}: Restart.File: no file {name}, with or without "
        f".vtu (looked for {looked}); --after FOLDER goes on from a run of the first deck instead"
    )


def _read(block: Block, path: Path) -> dict[str, Any]:
    import meshio

    try:
        with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
            return dict(meshio.read(path).point_data)
    except (IndexError, ValueError):  # no cells, as in PeriDEM's own files: meshio wants some
        import pyvista

        found = pyvista.read(path)
        return dict(found.point_data) if isinstance(found, pyvista.DataSet) else {}
    except (meshio.ReadError, KeyError, SyntaxError, SystemExit) as error:
        # meshio says what it thinks in print, and would end the program
        why = "" if isinstance(error, SystemExit) else f": {error}"
        raise block.error("File", f"{path} cannot be read as a VTU file{why}") from error
