"""Styles, source files, modules, examples and tests are all in the lists that are kept of them."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE, EXAMPLES, TESTS = (ROOT / name for name in ("src/PERIDEM", "examples", "tests"))


def styles() -> set[str]:
    """As in ``fix peridem/wall``: all that a person may use; capitals are for what styles make."""
    found = set()
    command = {"Atom": "atom_style", "Pair": "pair_style", "Fix": "fix", "Compute": "compute"}
    for header in SOURCE.glob("*.h"):
        for kind, name in re.findall(r"^(\w+)Style\((peridem[\w/]*),", header.read_text(), re.M):
            found.add(f"{command[kind]} {name}")
    return found


def used_in(text: str) -> set[str]:
    """Styles in the commands of a script, or of a program that writes one; those of a pair_style
    line may stand behind hybrid/overlay.
    """
    text = re.sub(r"^\s*#.*", "", text, flags=re.M)
    found = set()
    for command, name in re.findall(r"\b(fix|compute)\s+\S+\s+\S+\s+(peridem/\w+)", text):
        found.add(f"{command} {name}")
    if re.search(r'\badapt="', text):  # the option of Scene that writes the fix
        found.add("fix peridem/adapt")
    for command, rest in re.findall(r"\b(atom_style|pair_style)\s+([^\n]*)", text):
        found |= {f"{command} {name}" for name in re.findall(r"\bperidem(?:/\w+)?", rest)}
    return found


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Of the examples: those that lie there, or as parts within Python, and two that Python writes,
    one of them with cracks, one with an account of energy.
    """
    text = "\n".join(
        path.read_text() for kind in ("*/in.*", "*/*.py") for path in EXAMPLES.glob(kind)
    )
    folder = tmp_path_factory.mktemp("examples")
    for name in ("precracked", "aggregate"):
        command = [sys.executable, EXAMPLES / name / f"{name}.py", "--small", "--no-run"]
        done = subprocess.run(
            [*command, "--output", folder / name],
            capture_output=True,
            text=True,
            env={**os.environ, "MPLBACKEND": "Agg"},
        )
        assert done.returncode == 0, done.stderr
    for path in folder.rglob("in.*"):
        text += "\n" + path.read_text()
    return text


def test_the_styles_are_found():
    assert {"atom_style peridem", "pair_style peridem/lps", "fix peridem/wall"} < styles()
    assert len(styles()) >= 11
    assert used_in("pair_style hybrid/overlay peridem/lps peridem/contact") == {
        "pair_style peridem/lps",
        "pair_style peridem/contact",
    }


def test_every_style_has_a_row_of_tests():
    rows = "\n".join(re.findall(r"^\| (.*?) \|", (TESTS / "README.md").read_text(), re.M))
    assert {style for style in styles() if f"`{style}" not in rows} == set()


def test_every_style_is_in_an_example_or_the_readme_says_why_not(scripts):
    text = (EXAMPLES / "README.md").read_text()
    excused = set(re.findall(r"^- `([^`]+)`: .", text.split("\n## Not in an example\n")[1], re.M))
    assert styles() - used_in(scripts) == excused, "'Not in an example' of examples/README.md"


def test_every_source_file_is_in_the_readme():
    text = (SOURCE / "README").read_text()
    names = {path.stem for path in SOURCE.glob("*.[ch]*")}
    assert len(names) > 40
    assert {name for name in names if not re.search(rf"\b{name}\b", text)} == set()
    assert (
        set(re.findall(r"\b(?:atom_vec|pair|fix|compute)_peridem\w*|\bperidem_\w+", text)) <= names
    )


def test_every_module_is_in_the_readme():
    text = (ROOT / "python" / "README.md").read_text()
    package = ROOT / "python" / "peridem"
    modules = {path.stem for path in package.glob("[!_]*.py")}
    modules |= {path.parent.name for path in package.glob("*/__init__.py")}
    assert {name for name in modules if f"`{name}`" not in text} == set()


def test_every_example_is_in_the_gallery_with_its_picture():
    text = (EXAMPLES / "README.md").read_text()
    folders = [path.name for path in EXAMPLES.iterdir() if list(path.glob("README.md"))]
    assert len(folders) > 10
    for name in folders:
        row = re.search(rf"^\| \[{name}\]\({name}\) \|(.*)\|(.*)\|(.*)\|$", text, re.M)
        assert row, f"no row for {name}"
        assert re.search(r"second|minute|hour", row[3]), f"{name}: how long it takes"
        pictures = [path.name for path in (EXAMPLES / name).glob("*.png")]
        assert any(f"{name}/{picture}" in text for picture in pictures), f"no picture of {name}"
        assert all(p in (EXAMPLES / name / "README.md").read_text() for p in pictures), name


def test_every_example_is_run_by_a_test():
    tests = "\n".join(path.read_text() for path in (TESTS / "python").glob("test_*.py"))
    tests += (TESTS / "verification" / "test_drum.py").read_text()
    folders = [path.parent.name for path in EXAMPLES.glob("*/README.md")]
    assert {name for name in folders if f'"{name}"' not in tests} == set()


def test_every_test_file_is_in_the_map():
    text = (TESTS / "README.md").read_text()
    names = {str(path.relative_to(TESTS)) for path in TESTS.glob("*/test_*.py")}
    assert len(names) > 60
    assert {name for name in names if name not in text} == set()


def test_no_header_includes_itself():
    """Over any number of others; LAMMPS's own headers include none of ours."""
    included = {
        path.name: set(re.findall(r'#include "((?:\w+_)?peridem\w*\.h)"', path.read_text()))
        for path in SOURCE.glob("*.h")
    }
    assert not cycle(included)


def imports_of(path: Path, modules: set[str]) -> set[str]:
    """Modules that a file imports when it is itself imported, not only when a function runs."""
    found = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Import):
            found |= {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom):
            inside = {f"{node.module}.{one.name}" for one in node.names}
            found |= inside & modules or {str(node.module)}
    return found & modules


def test_no_module_imports_itself():
    """Over any number of others."""
    package = ROOT / "python" / "peridem"
    paths = {
        ".".join(path.relative_to(package.parent).with_suffix("").parts): path
        for path in package.rglob("*.py")
    }
    paths = {name.removesuffix(".__init__"): path for name, path in paths.items()}
    assert len(paths) > 40
    assert not cycle({name: imports_of(path, set(paths)) for name, path in paths.items()})


def cycle(leads_to: dict[str, set[str]]) -> list[str]:
    """Names, each of which leads to the next and the last to the first; empty if there are none."""
    left = {name: {one for one in after if one in leads_to} for name, after in leads_to.items()}
    while True:
        ends = {name for name, after in left.items() if not after}
        if not ends:
            return sorted(left)
        left = {name: after - ends for name, after in left.items() if name not in ends}


def test_cycles_are_found():
    assert cycle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["a", "b", "c"]
    assert cycle({"a": {"b"}, "b": {"c"}, "c": set()}) == []
