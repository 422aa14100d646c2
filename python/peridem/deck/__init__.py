"""PeriDEM decks: YAML input files with their meshes and particle tables, as scenes.

::

    deck = peridem.deck.load("input_0.yaml")
    print("\\n".join(deck.report))
    deck.scene.write("out/deck")

What PeriDEM computes wrongly is put right unless ``as_published`` is asked for; either way the
report says what is taken differently, what has no counterpart and which keys nobody knows.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from peridem.deck import source
from peridem.deck.build import Built, build
from peridem.deck.source import DeckError, Report
from peridem.scene import Scene

__all__ = ["Deck", "DeckError", "load"]


@dataclass(frozen=True, eq=False)
class Deck:
    """A deck that has been read.

    Attributes:
        path: of the file.
        scene: what it says.
        report: what was taken differently, left out or not understood, one line each.
        grains: for each particle of the deck, from 0: number of its grain in the scene, from 1, or
            None if it became a surface.
        as_published: whether PeriDEM's own behaviour was asked for.
    """

    path: Path
    scene: Scene
    report: list[str]
    grains: list[int | None]
    as_published: bool


def load(path: str | Path, as_published: bool = False, after: str | Path | None = None) -> Deck:
    """Read a deck with its meshes and particle table.

    Args:
        path: of the YAML file; other files are looked for beside it.
        as_published: as PeriDEM computes it (constants of 3D in 2D, bonds that break in compression
            too, its contact stiffness, time step and walls of nodes) instead of right physics.
        after: the folder of a run of the same particles, with whose end the deck begins: a second
            stage. Walls that lie elsewhere than in the deck of that run are put there.

    Raises:
        FileNotFoundError: there is no such file.
        DeckError: it cannot be read; one line with file, line and key.
    """
    path = Path(path)
    root, report = source.read(path), Report(path)
    built: Built = build(root, report, as_published, None if after is None else Path(after))
    for place in root.all_repeated():
        report.add(place, "given twice; the first one counts")
    for place, close in root.unread():
        hint = f" (did you mean {close[0]}?)" if close else ""
        report.add(place, f"unknown key, not used{hint}")
    return Deck(path, built.scene, report.lines(), built.grains, as_published)
