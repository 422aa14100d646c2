"""What `make lint` checks: the style and the types of every file. CI comes by here."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
TOOLS = Path(sys.executable).parent


def check(program: str, *arguments: str | Path) -> None:
    path = TOOLS / program
    if not path.is_file():
        pytest.skip(f"{path} is not there: make build")
    done = subprocess.run([path, *arguments], cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]


def sources() -> list[Path]:
    return [
        path
        for folder in ("src/PERIDEM", "bench")
        for path in sorted((ROOT / folder).iterdir())
        if path.suffix in (".cpp", ".h")
    ]


def test_python_has_no_lint():
    check("ruff", "check", ".")


def test_python_is_formatted():
    check("ruff", "format", "--check", ".")


def test_cpp_is_formatted():
    assert len(sources()) > 80
    check("clang-format", "--dry-run", "-Werror", *sources())


@pytest.mark.slow
def test_types():
    check("mypy", "--config-file", "python/pyproject.toml", "python/peridem")


def test_cpp_says_whose_it_is():
    """The head of every source file, as in LAMMPS's own."""
    for path in sources():
        if path.parent.name != "PERIDEM":
            continue
        head = "\n".join(path.read_text().splitlines()[:12])
        assert "GNU General Public License" in head, path


SCREEN = 50  # lines


def long_functions(text: str) -> list[str]:
    """What is longer than a screen, in a file that is formatted: the brace that opens a function
    has a line of its own, and the one that closes it stands as deep."""
    lines = text.splitlines()
    found = []
    for k, line in enumerate(lines):
        if line.strip() != "{":
            continue
        last = next(n for n in range(k, len(lines)) if lines[n].startswith(line[:-1] + "}"))
        if last - k + 1 > SCREEN:
            found.append(f"{lines[k - 1]} ({last - k + 1} lines)")
    return found


def test_no_cpp_function_is_longer_than_a_screen():
    short, long = ("\n".join(["void f()", "{", *["  x++;"] * n, "}"]) for n in (48, 49))
    assert not long_functions(short) and len(long_functions(long)) == 1
    for path in sources():
        assert not long_functions(path.read_text()), path


def long_python(text: str) -> list[str]:
    """Functions that are longer than a screen without their docstrings."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first, last = node.body[0], node.end_lineno or 0
        said = ast.get_docstring(node, clean=False) is not None
        lines = last - node.lineno + 1 - said * ((first.end_lineno or 0) - first.lineno + 1)
        if lines > SCREEN:
            found.append(f"{node.name} ({lines} lines)")
    return found


def test_no_python_function_is_longer_than_a_screen():
    short, long = (
        "\n".join(["def f():", '    """Says', '    so."""', *["    x = 1"] * n]) for n in (49, 50)
    )
    assert not long_python(short) and long_python(long) == ["f (51 lines)"]
    paths = [
        path
        for folder in ("python/peridem", "examples", "bench", "doc", "tests")
        for path in sorted((ROOT / folder).rglob("*.py"))
    ]
    assert len(paths) > 150
    for path in paths:
        assert not long_python(path.read_text()), path


def test_the_citation_names_the_software_and_its_paper():
    """Fields that the Citation File Format 1.2.0 demands, and the numbers that must agree."""
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= set(cff)
    assert cff["cff-version"] == "1.2.0" and cff["type"] == "software"
    project = (ROOT / "python" / "pyproject.toml").read_text()
    assert f'version = "{cff["version"]}"' in project
    assert f'license = "{cff["license"]}"' in project
    for entry in [cff, *cff["references"]]:
        assert entry["title"] and entry["type"] in ("software", "article")
        for author in entry["authors"]:
            assert set(author) in ({"name"}, {"family-names", "given-names"}), author
    dois = {entry["doi"] for entry in cff["references"]}
    assert "10.1016/j.jmps.2021.104376" in dois  # Jha, Desai, Bhattacharya, Lipton 2021
    assert all(re.fullmatch(r"10\.\d{4}/\S+", doi) for doi in dois)


def test_the_hooks_run_the_programs_of_make_lint():
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    assert {repo["repo"] for repo in hooks} == {"local"}  # nothing to fetch
    entries = [hook["entry"] for hook in hooks[0]["hooks"]]
    recipe = (ROOT / "Makefile").read_text().split("\nlint:")[1].split("\n\n")[0]
    for program in ("ruff check", "ruff format", "mypy", "clang-format"):
        assert any(f".venv/bin/{program}" in entry for entry in entries), program
        assert program in recipe, program


# ---- tests ---------------------------------------------------------------------------------------


def functions() -> list[tuple[Path, ast.FunctionDef]]:
    return [
        (path, node)
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef)
    ]


def called(node: ast.AST) -> set[str]:
    calls = [one.func for one in ast.walk(node) if isinstance(one, ast.Call)]
    return {getattr(one, "attr", getattr(one, "id", "")) for one in calls}


def asserting(found: list[tuple[Path, ast.FunctionDef]]) -> set[ast.FunctionDef]:
    """Functions with an assertion, or a call of a helper with one."""
    names: set[str] = {"raises", "warns", "fail"}
    while True:
        can_fail = {
            node
            for _, node in found
            if any(isinstance(one, ast.Assert) for one in ast.walk(node))
            or any(name in names or name.startswith("assert") for name in called(node))
        }
        more = {node.name for node in can_fail if not node.name.startswith("test_")} - names
        if not more:
            return can_fail
        names |= more


def test_every_test_can_fail():
    found = functions()
    can_fail = asserting(found)
    tests = [(path, node) for path, node in found if node.name.startswith("test_")]
    assert len(tests) > 800
    assert [f"{path}: {node.name}" for path, node in tests if node not in can_fail] == []
    empty = ast.parse("def test_x():\n    run()\ndef run():\n    pass").body
    assert asserting([(ROOT, node) for node in empty]) == set()


def tolerances(node: ast.FunctionDef) -> list[int]:
    """Lines with a tolerance: of approx and allclose, and small numbers that something is below."""
    lines = []
    for one in ast.walk(node):
        if isinstance(one, ast.keyword) and one.arg in ("rel", "abs", "rtol", "atol"):
            if getattr(one.value, "value", None):
                lines.append(one.value.lineno)
        elif isinstance(one, ast.Compare) and isinstance(one.ops[-1], ast.Lt | ast.LtE):
            last = one.comparators[-1]
            small = getattr(last.left if isinstance(last, ast.BinOp) else last, "value", None)
            if isinstance(small, float) and 0.0 < small < 0.5:
                lines.append(last.lineno)
    return lines


def test_every_tolerance_has_something_said_about_it():
    """A comment or a docstring in its test; that it is the reason, a reader has to see."""
    silent = []
    for path, node in functions():
        lines = tolerances(node) if node.name.startswith("test_") else []
        # rows of the report of verification say why themselves
        if not lines or ast.get_docstring(node) or "near" in called(node):
            continue
        first = min([node.lineno, *(one.lineno for one in node.decorator_list)])
        body = path.read_text().splitlines()[first - 1 : node.end_lineno]
        if not any(re.search(r"(?:^|\s)# (?!fmt:|noqa)", line) for line in body):
            silent.append(f"{path.relative_to(ROOT)}: {node.name}")
    assert silent == []
