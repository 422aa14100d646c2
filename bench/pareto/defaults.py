"""``## Which defaults, and why``: what the runs of all cases say of each default of the package.

Everything in it follows from the tables of the parts that were measured; nothing is known
beforehand but the defaults.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from bench import table
from bench.pareto import front, worth
from bench.pareto.worth import CLEAR, Worth
from bench.table import Row

TITLE = "Which defaults, and why"
# what settings are called where the tables of the parts have a short name
WORDS = {"m": "horizon / spacing", "spring": "contact spring, form bulk"}


@dataclass(frozen=True)
class Case:
    """One quantity of one part.

    Attributes:
        name: as it stands at the head of its column.
        rows: all runs, those that only tell of chance left out.
        default: the settings that the package has if nothing is said.
        size: the column of the resolution.
        floor: errors below it are chance.
        present: what the package has where ``default``, with which most runs were made, is better.
    """

    name: str
    rows: Sequence[Row]
    default: Mapping[str, object]
    size: str
    floor: float = 0.0
    present: Mapping[str, object] = field(default_factory=dict)


def cases(
    part: str,
    rows: Sequence[Row],
    default: Mapping[str, object],
    size: str,
    present: Mapping[str, object],
) -> list[Case]:
    """The quantities of a part; rows with a note tell of its scatter."""
    found = []
    kinds = list(dict.fromkeys(str(row[front.KIND]) for row in rows))
    for kind in kinds:
        mine = [row for row in rows if row[front.KIND] == kind]
        floor = max(
            (float(str(row[front.ERROR])) for row in mine if row.get(front.NOTE)), default=0
        )
        runs = [row for row in mine if not row.get(front.NOTE)]
        name = part if len(kinds) == 1 else kind
        found.append(Case(name, runs, default, size, floor, present))
    return found


def text(of: Sequence[Case]) -> str:
    """The section without its title; empty where nothing was measured."""
    if not of:
        return ""
    values = {case.name: _by_choice(case) for case in of}
    choices = sorted({choice for mine in values.values() for choice in mine}, key=_order)
    defaults = {
        key: value for case in of for key, value in worth.without(case.default, case.size).items()
    }
    present = {key: str(table.shown(v)) for case in of for key, v in case.present.items()}
    rows: list[Row] = []
    words: dict[str, list[tuple[str, str, dict[str, Worth]]]] = {}
    for choice in choices:
        mine = {name: found[choice] for name, found in values.items() if choice in found}
        setting, value = choice
        said = worth.verdict(list(mine.values()))
        cells = {name: str(mine.get(name, "")) for name in values}
        usual = defaults[setting]
        rows.append({"setting": WORDS.get(setting, setting), "default": usual, "instead": value})
        rows[-1] |= {**cells, "the other is": said}
        words.setdefault(setting, []).append((value, said, mine))
    listed = "\n".join(
        f"* {_sentence(key, defaults[key], words[key], present.get(key, ''))}" for key in words
    )
    return f"""\
How many times longer the default runs than another choice, both with nodes as fine as they need
for the same error: above 1 the other choice is better, and `<` and `>` stand where the default's
coarsest or finest nodes do not reach that error. The geometric mean over the resolutions that were
run; factors between {1 / CLEAR:g} and {CLEAR:g} are no clear difference.

{table.markdown(rows)}

{listed}

How far from the front runs with all defaults are:

{table.markdown([_distance(case) for case in of])}"""


def _order(choice: tuple[str, str]) -> tuple[str, float, str]:
    """By the setting, then by numbers, then by names."""
    setting, value = choice
    try:
        return setting, float(value), ""
    except ValueError:
        return setting, 0.0, value


def _by_choice(case: Case) -> dict[tuple[str, str], Worth]:
    found = worth.of_settings(case.rows, case.default, case.size, case.floor)
    return {(one.setting, one.value): one for one in found}


def _sentence(
    setting: str,
    base: str,
    others: Sequence[tuple[str, str, Mapping[str, Worth]]],
    present: str,
) -> str:
    """What follows for one setting; ``present``: what the package has, where it is not the base."""
    name = f"**{WORDS.get(setting, setting)}** {base}"
    parts = []
    for value, said, mine in others:
        up, down = _cited(mine, up=True), _cited(mine, up=False)
        if said == "better":
            parts.append(f"{value} is better ({up})")
        elif said == "depends on the case":
            parts.append(f"{value} is better for some ({up}) and worse for others ({down})")
        elif value == present:
            parts.append(
                f"{value}, which the package has, is {said}" + (f" ({down})" if down else "")
            )
    if any(said == "better" for _, said, _ in others):
        return f"{name} is beaten: {'; '.join(parts)}."
    if present:
        return f"{name}, with which the other runs are made: {'; '.join(parts)}."
    if parts:
        return f"{name} stays, as nothing else is better for all: {'; '.join(parts)}."
    return f"{name} stays: nothing else is clearly better for anything here."


def _cited(mine: Mapping[str, Worth], up: bool) -> str:
    clear = {
        name: one
        for name, one in mine.items()
        if (one.times >= CLEAR and one.bound >= 0 if up else one.times <= 1 / CLEAR)
    }
    return ", ".join(f"{name} {one}" for name, one in clear.items())


def _distance(case: Case) -> Row:
    """How many runs of the default lie on the front, and how far the others are from it."""
    series = worth.series(case.rows, case.default, case.size)
    far = [_number(row, front.COST) / _cheapest(case, row) for row in series]
    return {
        "case": case.name,
        "runs with all defaults": len(series),
        "on the front": sum(one <= 1.0 for one in far),
        "cost over that of the cheapest run with no larger error, at most": max(far, default=0.0),
    }


def _cheapest(case: Case, row: Row) -> float:
    error = max(_number(row, front.ERROR), case.floor)
    return min(
        _number(other, front.COST)
        for other in case.rows
        if max(_number(other, front.ERROR), case.floor) <= error
    )


def _number(row: Row, key: str) -> float:
    return float(str(row[key]))
