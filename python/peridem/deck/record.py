"""What the run of a deck keeps about its particles, for a deck that goes on from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from peridem.deck.source import Block, DeckError
from peridem.stages import End


@dataclass(frozen=True)
class Record:
    """The particles of a deck, as ``scene.json`` keeps them.

    Attributes:
        as_published: how the deck was read.
        grains: number of each particle's grain, from 1; None: it became surfaces.
        centres: mean of the nodes of each particle's mesh.
        surfaces: names of those that each particle became.
    """

    as_published: bool
    grains: list[int | None]
    centres: list[list[float]]
    surfaces: list[list[str]]

    @classmethod
    def of(cls, root: Block, end: End, count: int, as_published: bool) -> Record:
        """That of a run which is of so many particles, read in the same way.

        Raises:
            DeckError: it is not.
        """
        folder, kept = end.output.folder, end.output.summary.get("source", {})
        if "centres" not in kept:
            raise DeckError(f"{root.path}: the run in {folder} was not made from a deck")
        known = cls(**kept)
        if known.as_published != as_published:
            how = "with" if known.as_published else "without"
            raise DeckError(
                f"{root.path}: the deck of the run in {folder} was read {how} --as-published, this "
                "one must be too"
            )
        if len(known.grains) != count:
            raise DeckError(
                f"{root.path}: {count} particles, where the deck of the run in {folder} had "
                f"{len(known.grains)}; they must be the same"
            )
        return known

    def kept(self) -> Mapping[str, Any]:
        """What :attr:`peridem.scene.Scene.source` is."""
        return asdict(self)
