"""Cases with known answers, shared by the tests (small) and the report (full).

To add one: a module with a list ``CASES``, and its name in ``MODULES`` under its heading.
"""

from __future__ import annotations

from importlib import import_module

from .base import Case

MODULES: dict[str, tuple[str, ...]] = {
    "Uniform strain": ("patch",),
    "Waves": ("waves",),
    "Convergence": ("convergence",),
    "Contact": ("contact",),
    "Fracture": ("fracture",),
    "Collisions of the first paper": ("seeds",),
    "Hard cases": ("hard_contact", "hard_grains", "hard_steps"),
    "Faults met elsewhere": ("hard_faults",),
    "Invariance": ("hard_invariance",),
}


def by_heading() -> dict[str, list[Case]]:
    """All cases, in the order of the report."""
    return {
        heading: [case for name in names for case in import_module(f".{name}", __name__).CASES]
        for heading, names in MODULES.items()
    }


def all_cases() -> list[Case]:
    cases = [case for found in by_heading().values() for case in found]
    names = [case.name for case in cases]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"cases of one name: {sorted(twice)}")
    return cases


def case_named(name: str) -> Case:
    for case in all_cases():
        if case.name == name:
            return case
    raise KeyError(f"no case {name!r}; there are {', '.join(c.name for c in all_cases())}")
