"""The text of a deck: YAML whose every value knows its line, and whose unread keys are known.

A :class:`Block` is one mapping of the file. Reading a key marks it, so that what nobody has read
can be named at the end (:meth:`Block.unread`).
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterator
from pathlib import Path

import yaml

TRUE, FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


class DeckError(ValueError):
    """A deck that cannot be read: one line with the file, the line and the key."""


class Report:
    """What was taken differently, left out or not understood.

    Messages of several places are gathered into one line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._places: dict[str, list[tuple[int, str]]] = {}

    def add(self, place: tuple[int, str], text: str) -> None:
        """A message about a place: its line and key."""
        known = self._places.setdefault(text, [])
        if place not in known:
            known.append(place)

    def lines(self) -> list[str]:
        """The messages, in the order of the lines they speak of."""
        ordered = sorted(self._places.items(), key=lambda item: min(item[1])[0])
        return [self._line(places, text) for text, places in ordered]

    def _line(self, places: list[tuple[int, str]], text: str) -> str:
        places = sorted(places)
        line, key = places[0]
        where = ": ".join(filter(None, (self.path.name + (f":{line}" if line else ""), key)))
        if len(places) == 2:
            where += f" and {places[1][1]}"
        elif len(places) > 2:
            where += f" and {len(places) - 1} others"
        return f"{where}: {text}"


class Block:
    """One mapping of a deck, or an empty one where the deck has none."""

    def __init__(
        self, path: Path, keys: tuple[str, ...], node: yaml.MappingNode | None, line: int
    ) -> None:
        self.path, self.keys, self.line = path, keys, line
        self._values: dict[str, yaml.Node] = {}
        self._lines: dict[str, int] = {}
        self._blocks: dict[str, Block] = {}
        self._read: set[str] = set()
        self.repeated: list[tuple[int, str]] = []
        for key_node, value in node.value if node is not None else ():
            key = str(key_node.value)
            if key in self._values:  # the first one counts
                self.repeated.append((key_node.start_mark.line + 1, self._name(key)))
                continue
            self._values[key] = value
            self._lines[key] = key_node.start_mark.line + 1

    def _name(self, key: str = "") -> str:
        return ".".join((*self.keys, key) if key else self.keys)

    def place(self, key: str = "") -> tuple[int, str]:
        """Line and full name of a key, or of the block itself."""
        return self._lines.get(key, self.line), self._name(key)

    def error(self, key: str, message: str) -> DeckError:
        """An error about a key."""
        line, name = self.place(key)
        return DeckError(f"{self.path}:{line}: {name}: {message}")

    def missing(self, key: str, what: str) -> DeckError:
        """An error about a key that is not there; it names one that looks alike."""
        letters = re.sub(r"\d", "", key)  # Set_1 is not meant where Set_2 is missing
        others = [
            k for k in self._values if k not in self._read and re.sub(r"\d", "", k) != letters
        ]
        close = difflib.get_close_matches(key, others, 1)
        hint = f" (did you mean {key} where it says '{close[0]}'?)" if close else ""
        inside = self._name() or "the deck"
        return DeckError(f"{self.path}:{self.line}: {inside}: {key} is missing: {what}{hint}")

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    # ---- values ----------------------------------------------------------------------------------

    def block(self, key: str) -> Block:
        """The mapping of a key; empty if there is none."""
        self._read.add(key)
        if key not in self._blocks:
            node = self._values.get(key)
            if node is not None and not isinstance(node, yaml.MappingNode):
                if getattr(node, "value", None) in ("", "null", "~"):
                    node = None
                else:
                    raise self.error(key, "a block with keys of its own needed")
            line = self._lines.get(key, self.line)
            self._blocks[key] = Block(self.path, (*self.keys, key), node, line)
        return self._blocks[key]

    def part(self, key: str, whole: bool) -> Block:
        """The mapping of a key; the block itself where it is not there and ``whole`` allows it.

        Old decks of one particle have no zones: the whole section is that of the first one.
        """
        return self if whole and key not in self and len(self._values) else self.block(key)

    def text(self, key: str, default: str | None = None) -> str:
        """A word or a number as it is written.

        Raises:
            DeckError: it is not there and has no default, or is a list or a block.
        """
        self._read.add(key)
        node = self._values.get(key)
        if node is None:
            if default is None:
                raise self.missing(key, "it is needed")
            return default
        if not isinstance(node, yaml.ScalarNode):
            raise self.error(key, "a single value needed, not a list or a block")
        return str(node.value).strip()

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number."""
        if key not in self and default is not None:
            self._read.add(key)
            return default
        return self._number(key, self.text(key))

    def positive(self, key: str, default: float | None = None) -> float:
        """A number above 0."""
        value = self.number(key, default)
        if key in self and not value > 0.0:
            raise self.error(key, f"must be above 0, not {value:g}")
        return value

    def whole(self, key: str, default: int | None = None) -> int:
        """A whole number of 0 or more."""
        value = self.number(key, default)
        if value != int(value) or value < 0:
            raise self.error(key, f"a whole number of 0 or more needed, not {value:g}")
        return int(value)

    def flag(self, key: str, default: bool = False) -> bool:
        """True or false."""
        word = self.text(key, str(default)).lower()
        if word not in TRUE + FALSE:
            raise self.error(key, f"true or false needed, not '{word}'")
        return word in TRUE

    def words(self, key: str) -> list[str]:
        """A list of words; a single one counts as a list of one. Empty if there is none."""
        self._read.add(key)
        node = self._values.get(key)
        if node is None:
            return []
        if isinstance(node, yaml.ScalarNode):
            return [str(node.value).strip()] if str(node.value).strip() else []
        if not isinstance(node, yaml.SequenceNode) or not all(
            isinstance(item, yaml.ScalarNode) for item in node.value
        ):
            raise self.error(key, "a list of single values needed")
        return [str(item.value).strip() for item in node.value]

    def numbers(self, key: str, count: int | None = None) -> list[float]:
        """A list of numbers; of the given length if it is not empty."""
        values = [self._number(key, word) for word in self.words(key)]
        if count is not None and values and len(values) != count:
            raise self.error(key, f"{count} numbers needed, not {len(values)}")
        return values

    def wholes(self, key: str) -> list[int]:
        """A list of whole numbers of 0 or more."""
        values = self.numbers(key)
        for value in values:
            if value != int(value) or value < 0:
                raise self.error(key, f"whole numbers of 0 or more needed, not {value:g}")
        return [int(value) for value in values]

    def choice(self, key: str, allowed: tuple[str, ...], default: str | None = None) -> str:
        """One of several words."""
        word = self.text(key, default)
        if word not in allowed:
            close = difflib.get_close_matches(word, allowed, 1)
            hint = f" (did you mean {close[0]}?)" if close else ""
            raise self.error(key, f"must be one of {', '.join(allowed)}, not '{word}'{hint}")
        return word

    def _number(self, key: str, word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            raise self.error(key, f"a number needed, not '{word}'") from None
        if not math.isfinite(value):
            raise self.error(key, f"a finite number needed, not {word}")
        return value

    # ---- what is left ----------------------------------------------------------------------------

    def skip(self, *keys: str) -> list[str]:
        """Mark keys, with all below them, as seen; returns those that are there."""
        here = [key for key in keys if key in self]
        for key in here:
            self._read.add(key)
            self._blocks.pop(key, None)
        return here

    def unread(self) -> Iterator[tuple[tuple[int, str], list[str]]]:
        """Places of keys that nobody has asked for, with the keys that would have been known."""
        for key in self._values:
            if key not in self._read:
                yield self.place(key), difflib.get_close_matches(key, self._read, 1)
            elif key in self._blocks:
                yield from self._blocks[key].unread()

    def all_repeated(self) -> Iterator[tuple[int, str]]:
        """Places of keys that are given twice."""
        yield from self.repeated
        for block in self._blocks.values():
            yield from block.all_repeated()


def read(path: str | Path) -> Block:
    """The outermost block of a deck.

    Raises:
        FileNotFoundError: there is no such file.
        DeckError: it is no YAML, or not a mapping.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no deck {path}")
    try:
        text = path.read_text()
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except UnicodeDecodeError as error:
        raise DeckError(f"{path}: this is no text file: {error}") from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = mark.line + 1 if mark is not None else 1
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise DeckError(f"{path}:{line}: this is not YAML: {problem}") from error
    if not isinstance(node, yaml.MappingNode):
        raise DeckError(f"{path}:1: a deck has blocks such as Model and Material; there are none")
    return Block(path, (), node, 1)
