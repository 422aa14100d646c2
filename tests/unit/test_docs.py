"""The manual builds without a warning, and what it promises is there."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOC = ROOT / "doc"
sys.path.insert(0, str(DOC))

import check_pages  # noqa: E402
import check_syntax  # noqa: E402
import howtos  # noqa: E402

LMP = Path(os.environ.get("LAMMPS_LMP", ROOT / "build" / "lmp")).resolve()

STYLES = sorted(path.stem for path in DOC.glob("*_peridem*.rst") if "howto" not in path.stem)
HEADINGS = (
    "Syntax",
    "Examples",
    "Description",
    "Restrictions",
    "Related commands",
    "Default",
)


@pytest.fixture(scope="module")
def html(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The manual, built as ``make docs`` does it: any warning is an error."""
    folder = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    command += ["-d", str(folder / "trees"), str(DOC), str(folder / "html")]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-6000:]
    return folder / "html"


@pytest.mark.slow
def test_every_page_can_be_reached(html: Path) -> None:
    """Sphinx warns of pages outside every toctree; here: from the start page, by its links."""
    seen: set[Path] = set()
    ahead = [html / "index.html"]
    while ahead:
        page = ahead.pop()
        if page in seen:
            continue
        seen.add(page)
        links = re.findall(r'href="([^"#:]+\.html)', page.read_text())
        ahead += [(page.parent / link).resolve() for link in links]
    made = {page.resolve() for page in html.rglob("*.html") if "_static" not in page.parts}
    assert made - {page.resolve() for page in seen} == set()
    assert len(made) > 50


@pytest.mark.slow
def test_formulas_are_in_the_pages_and_nothing_comes_from_elsewhere(html: Path) -> None:
    """The manual is read where there is no network: no script, style or font of another host."""
    text = (html / "theory.html").read_text()
    assert text.count("<math") > 50
    for page in html.rglob("*.html"):
        outside = re.findall(
            r'<(?:script|link|img)[^>]+(?:src|href)="https?://[^"]+', page.read_text()
        )
        assert outside == [], page


@pytest.mark.slow
def test_names_of_functions_stand_apart_in_formulas(html: Path) -> None:
    """Browsers leave no space around them by themselves: 2cosT."""
    text = "".join((html / "theory.html").read_text().split())
    assert re.search(r"<mn>2</mn><mspace[^>]*></mspace><mi>cos</mi><mo>[^<]*</mo><mspace", text)


def test_no_formula_has_an_empty_line() -> None:
    """What is before and after it would stand in one line, without a space."""
    split = re.compile(r"^ *\.\. math::\n\n(?: +\S.*\n)+\n +\S", re.M)
    assert split.search(".. math::\n\n   a = b\n\n   c = d\n")
    assert [path.name for path in DOC.glob("*.rst") if split.search(path.read_text())] == []


class Page(HTMLParser):
    """Of a page as browsers get it: where links may lead, where they lead, and the running text."""

    PROGRAMS = ("script", "style", "pre", "code", "math", "svg", "kbd")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.text = ""
        self.inside = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors.add(given.get("id") or "")
        self.links += [given[name] or "" for name in ("href", "src") if name in given]
        self.inside += tag in self.PROGRAMS

    def handle_endtag(self, tag: str) -> None:
        self.inside -= tag in self.PROGRAMS

    def handle_data(self, data: str) -> None:
        if not self.inside:
            self.text += data


# what a reader sees where Sphinx did not understand what was meant
RAW = re.compile(
    r":(?:doc|ref|math|mod|class|func|file):|``|`[^`]+`|\.\. [a-z-]+::|\]\(|\\(?:frac|sum)"
)


@pytest.fixture(scope="module")
def pages(html: Path) -> dict[Path, Page]:
    found = {path.resolve(): Page(path.read_text()) for path in html.rglob("*.html")}
    return {path: page for path, page in found.items() if "_static" not in path.parts}


@pytest.mark.slow
def test_links_lead_to_files_and_places_of_pages(pages: dict[Path, Page]) -> None:
    dead = []
    for path, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                assert re.match(r"https://[\w.-]+\.\w+(/\S*)?$", link), f"{path.name}: {link}"
                continue
            name, _, anchor = link.partition("#")
            there = (path.parent / name.partition("?")[0]).resolve() if name else path
            if not there.exists() or (anchor and there in pages
                                      and anchor not in pages[there].anchors):  # fmt: skip
                dead.append(f"{path.name}: {link}")
    assert dead == []
    assert sum(len(page.links) for page in pages.values()) > 5000


@pytest.mark.slow
def test_no_markup_is_left_in_the_text(pages: dict[Path, Page]) -> None:
    left = {path.name: found for path, page in pages.items() if (found := RAW.findall(page.text))}
    assert left == {}
    assert RAW.search("as :doc:`x` says") and RAW.search("[link](there)")


def test_every_style_has_a_page_with_the_headings_of_lammps() -> None:
    declared = set()
    for path in (ROOT / "src" / "PERIDEM").glob("*.h"):
        for kind, name in re.findall(
            r"^(Atom|Pair|Fix|Compute)Style\(([\w/]+),", path.read_text(), re.MULTILINE
        ):
            if name == name.lower():  # upper case: made by other styles, not by users
                declared.add(f"{kind.lower()}_{name}" if kind != "Atom" else f"atom_style_{name}")
    assert {name.replace("/", "_") for name in declared} == set(STYLES)
    for style in STYLES:
        text = (DOC / f"{style}.rst").read_text()
        for heading in HEADINGS:
            assert re.search(rf'^{heading}\n"+$', text, re.MULTILINE), f"{style} lacks {heading}"


@pytest.mark.parametrize("style", STYLES)
def test_a_page_has_the_form_of_lammps(style: str) -> None:
    """What LAMMPS's own pages of styles have, so that these can lie beside them."""
    text = (DOC / f"{style}.rst").read_text()
    kind, name = style.split("_peridem")[0], "peridem" + style.split("_peridem")[1]
    command = f"{kind if kind in ('fix', 'compute', 'atom_style') else 'pair_style'}"
    command += " " + name.replace("_", "/", 1)
    title = f"{command} command"
    assert text.startswith(f".. index:: {command}\n\n{title}\n{'=' * len(title)}\n")
    start = text.split("\nSyntax\n")[1]
    assert start.startswith('""""""\n\n.. code-block:: LAMMPS\n\n   ')
    if command.startswith(("fix", "compute")):
        assert f"* {command.split()[1]} = style name of this {kind} command" in text
        assert f":doc:`{kind} <{kind}>` command" in text
    restrictions = text.split("\nRestrictions\n")[1].split("\nRelated commands\n")[0]
    assert "is part of the PERIDEM package.  It is only enabled if" in restrictions
    assert ":doc:`Build package <Build_package>`" in restrictions
    if command.startswith("fix"):
        assert "\nRestart, fix_modify, output, run start/stop, minimize info\n" in text
        assert ":doc:`fix_modify <fix_modify>`" in text and "*start/stop* keywords" in text
    elif command.startswith("compute"):
        assert "\nOutput info\n" in text
    elif command.startswith("pair"):
        assert "\nMixing, shift, table, tail correction, restart, rRESPA info\n" in text
    related = text.split("\nRelated commands\n")[1].split("\nDefault\n")[0]
    assert ":doc:`" in related
    assert text.isascii()  # as LAMMPS asks of its pages
    assert not re.search(r"[ \t]$", text, re.MULTILINE)


def test_the_pages_of_lammps_that_are_linked_are_those_of_the_list() -> None:
    """A name that is neither a page here nor in the list ends the build of the manual."""
    links = re.compile(r":doc:`(?:[^`<]*<([^>]+)>|([^`<]+))`")
    found = [links.findall(path.read_text()) for path in DOC.glob("*.rst")]
    named = {one or other for pairs in found for one, other in pairs}
    listed = (DOC / "lammps_pages.txt").read_text().split()
    assert listed == sorted(set(listed), key=str.lower)
    assert set(listed) - named == set()


@pytest.mark.parametrize(
    "question", check_syntax.questions(), ids=lambda one: f"{one.page} {one.keyword}".strip()
)
def test_the_syntax_of_a_page_is_that_of_the_program(question: check_syntax.Question) -> None:
    """Keywords, and the words that they take, as the program's errors list them."""
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    assert check_syntax.differences(question, str(LMP)) == ""


def test_a_keyword_that_a_page_lacks_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    said = "Unknown fix peridem/timestep keyword nonsense: known are safety, every, other"
    monkeypatch.setattr(check_syntax, "answer", lambda line, lmp: said)
    [asked] = [one for one in check_syntax.questions() if one.page == "fix_peridem_timestep"]
    assert "lacks other" in check_syntax.differences(asked, "")


@pytest.mark.parametrize("style", STYLES)
def test_every_style_has_an_example_and_a_test(style: str) -> None:
    """A scene in examples/ or in the scripts that the Python package writes, and a test."""
    name = "atom_style" if style.startswith("atom") else style.split("_", 1)[1].replace("_", "/", 1)
    used = [*(ROOT / "examples").rglob("in.*"), *(ROOT / "examples").rglob("*.py")]
    used += [*(ROOT / "python" / "peridem").glob("*.py"), *DOC.glob("howto_*.rst")]
    assert any(name in path.read_text() for path in used), f"no example of {name}"
    tests = [*(ROOT / "tests").rglob("test_*.py")]
    assert any(name in path.read_text() for path in tests), f"no test of {name}"


@pytest.mark.parametrize("style", STYLES)
def test_the_examples_of_a_page_run_without_a_warning(style: str) -> None:
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    blocks = check_pages.examples((DOC / f"{style}.rst").read_text())
    assert blocks
    for script in (script for block in blocks for script in check_pages.scripts(block)):
        assert check_pages.tried(script, str(LMP)) == ""


def test_every_error_and_warning_is_explained() -> None:
    assert len(check_pages.messages()) > 150
    assert check_pages.missing_messages() == []


def test_every_module_of_the_package_that_users_import_is_in_the_reference() -> None:
    listed = set(re.findall(r":mod:`peridem\.(\w+)`", (DOC / "api.rst").read_text()))
    assert listed == {path.stem for path in (DOC / "api").glob("*.rst")}
    used = set()
    for path in [*(ROOT / "examples").rglob("*.py"), *DOC.glob("*.rst")]:
        text = path.read_text()
        used |= set(re.findall(r"from peridem\.(\w+) import", text))
        for names in re.findall(r"from peridem import ([\w, ]+)", text):
            used |= {name.strip() for name in names.split(",")}
    assert used - listed == set()


NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?"


def nearest(line: str, page: str) -> float:
    """How far the numbers of a line are from those that the page has between the same words.

    Three dots stand for a cell of a table, whatever is in it.
    """
    words = [re.escape(piece) for piece in re.split(NUMBER, " ".join(line.split()))]
    pattern = re.sub(r"\\ (?:\\\.){3}\\ ", "[^|]*", f"({NUMBER})".join(words))
    said = [float(number) for number in re.findall(NUMBER, line)]
    found = [
        max(
            abs(float(one) - other) / max(abs(other), 1e-300)
            for one, other in zip(match.groups(), said, strict=True)
        )
        for match in re.finditer(pattern, page)
    ]
    return min(found, default=math.inf)


# What pages say of numbers is rounded to two digits or less, so these may change by 2 % when they
# are measured anew; processor times scatter by some per cent more.
ALLOWED = {"verification.md": 0.02, "theory.rst": 0.02, "performance.md": 0.05, "README.md": 0.02}


def quotations() -> list[tuple[Path, Path, str]]:
    """Pages, and the lines of other pages that they speak of: in a comment of the page."""
    found = []
    for path in [*DOC.glob("*.rst"), ROOT / "README.md"]:
        pattern = r"^\.\. quoted from (\S+)\n((?: {3}.*\n)+)"
        if path.suffix == ".md":
            pattern = r"^<!-- quoted from (\S+)\n((?:.*\n)+?)-->"
        for name, lines in re.findall(pattern, path.read_text(), re.MULTILINE):
            found += [(path, path.parent / name, line.strip()) for line in lines.splitlines()]
    return found


@pytest.mark.parametrize(
    ("path", "source", "line"),
    quotations(),
    ids=[f"{path.name}: {line[:60]}" for path, _, line in quotations()],
)
def test_numbers_that_pages_quote_are_those_of_their_source(
    path: Path, source: Path, line: str
) -> None:
    page = " ".join(source.read_text().split())
    apart = nearest(line, page)
    assert apart < ALLOWED[source.name], f"{path.name}: {source.name} has no more '{line}'"


def test_quotations_are_found() -> None:
    assert len(quotations()) > 35
    assert nearest("a | 1.0 | ... | 3.0", "a | 1.01 | 2 7 | 3.0 |") == pytest.approx(0.01)
    assert nearest("a | 1.0 | ... | 3.0", "b | 1.01 | 2 | 3.0 |") == math.inf


# constants of the program, and what pages say of them
CONSTANTS = [
    ("SKIN", 1.25, "pair_peridem_contact", "it is set to 1.25 times that distance"),
    ("SKIN", 1.25, "differences", "neighbor skin is set to 1.25 times the contact distance"),
    ("SKIN", 1.25, "troubleshooting", "The skin: 1.25 times the contact radius is the default"),
    ("AUTO_FACTOR", 0.95, "pair_peridem_contact", "*radius*: 0.95 times the smallest distance"),
    ("DEFAULT_RATIO", 0.85, "pair_peridem_contact", "tangential = history 0.85"),
    ("IMPACT_STEPS", 10.0, "pair_peridem_contact", "slows the two bodies down within ten steps"),
    ("LINGER_WIDEST", 0.8, "pair_peridem_contact", "or by 0.8 of the contact distance (or the"),
    ("LINGER", 10.0, "pair_peridem_contact", "apart by ten times their deepest overlap"),
    ("WORTH_A_WARNING", 0.01, "pair_peridem_contact", "Overlaps deeper than 1 % of the contact"),
    ("WORTH_A_WARNING", 0.01, "fix_peridem_wall", "at the start by more than 1 % of the contact"),
    ("MAXTOUCH", 64, "pair_peridem_contact", "one node has room for 64 contacts"),
    ("MAXNODES", 4000, "pair_peridem_lps", "of more than 4000 nodes"),
    ("WEIGHTLESS", 1e-6, "pair_peridem_lps", "whose :math:`w v` is below 1e-6 is no bond"),
    ("SOFTENED", 10.0, "pair_peridem_pmb", "ten times the stretch at which it pulls hardest"),
    ("CRUSHED", 0.25, "fix_peridem_bonds", "bonds compressed below 1/4 of their length"),
    ("SAMPLES", 32, "fix_peridem_bonds", "at 33 places along a bond; one thinner than 1/32"),
    ("MAXPATIENCE", 64, "fix_peridem_adapt", "(up to 64 times)"),
    ("UNBALANCED", 0.2, "fix_peridem_adapt", "balance to a fifth of their sizes"),
    ("FACTOR_TENSION", 1.7, "fix_peridem_adapt", ":math:`c` is 1.7, and 3.5 where bonds break in"),
    ("FACTOR_BOTH", 3.5, "fix_peridem_adapt", ":math:`c` is 1.7, and 3.5 where bonds break in"),
    ("TRAVEL", 0.1, "compute_peridem_dt", "moves more than a tenth of the (smallest) contact"),
    ("ACCURACY", 1e-4, "compute_peridem_dt", "by Lanczos' method, settled to 1e-4"),
    ("NEAR", 1.8, "compute_peridem_atom", "closer than 1.8 cell sizes"),
    ("COS_OPEN", 0.5, "compute_peridem_atom", "a direction within 60 degrees of which"),
]


@pytest.mark.parametrize(("name", "value", "page", "said"), CONSTANTS)
def test_pages_say_what_constants_of_the_program_are(
    name: str, value: float, page: str, said: str
) -> None:
    source = "".join(path.read_text() for path in (ROOT / "src" / "PERIDEM").glob("*.[ch]*"))
    found = re.findall(rf"constexpr \w+ (?:\w+ = [\d.]+, )?{name} = ([\w.-]+)", source)
    found += re.findall(rf"constexpr \w+ {name} = ([\d.e-]+),", source)
    assert found and {float(one) for one in found} == {value}, f"{name} is {found}"
    assert said in " ".join((DOC / f"{page}.rst").read_text().split())


def test_the_page_of_the_time_step_shows_what_is_printed(tmp_path: Path) -> None:
    """Of the scene that the Examples of pages run in."""
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    script = check_pages.SCENE + check_pages.PAIR
    (tmp_path / "in").write_text(script + "fix step all peridem/timestep\nrun 0\n")
    command = [LMP, "-in", "in", "-nocite", "-log", "none"]
    done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True)
    pattern = r"PERIDEM: time step set to .*"
    [shown] = re.findall(pattern, (DOC / "fix_peridem_timestep.rst").read_text())
    [printed] = re.findall(pattern, done.stdout)
    # four digits are printed
    assert nearest(shown, printed) < 2e-3


def test_commands_of_the_howtos_name_targets_and_files_that_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for page in [*DOC.glob("*.rst"), DOC / "install.md"]:
        text = page.read_text()
        named = set(re.findall(r"``(?:\w+=\S+ )*make (\w+)``", text))
        assert named <= targets, page.name


def test_files_that_the_pages_name_exist() -> None:
    """Paths between backticks, from the repository or from the folder of the page."""
    places = "src|examples|tests|bench|doc|cmake|python|unit|parallel|verification|fuzz|support"
    path = re.compile(rf"(?<!:doc:)(?<!`)``?((?:{places}|install)/(?!PeriDEM/)[\w./*-]+)``?")
    named = 0
    pages = [*DOC.glob("*.rst"), *DOC.glob("*.md"), *ROOT.glob("*.md")]
    for page in [*pages, *ROOT.glob("*/README.md"), *ROOT.glob("examples/*/README.md")]:
        # NAME stands for what somebody adds; examples/PeriDEM is in the repository of PeriDEM
        for file in path.findall(page.read_text().replace("NAME", "*")):
            found = [
                place for place in (ROOT, page.parent, ROOT / "tests") if any(place.glob(file))
            ]
            assert found, f"{page.relative_to(ROOT)}: {file}"
            named += 1
    assert named > 200


def test_classes_and_functions_that_contributors_are_told_of_exist() -> None:
    places = ("src/PERIDEM/*.[ch]*", "python/peridem/**/*.py", "tests/**/*.py", "doc/*.py")
    source = "".join(path.read_text() for place in places for path in ROOT.glob(place))
    text = (ROOT / "CONTRIBUTING.md").read_text()
    names = set(re.findall(r"`((?:\w+(?:::|->|\.))*[A-Za-z]\w*)(?:\([^`]*\))?`", text))
    # files by their names alone, and what somebody adds
    folders = ("src", "python", "tests", "doc", "examples", "bench", "cmake")
    files = {path.name for folder in folders for path in (ROOT / folder).rglob("*")}
    files |= {path.name for path in ROOT.iterdir()}
    names -= files | {name for name in names if "NAME" in name}
    assert len(names) > 25
    last = {re.split(r"::|->|\.", name)[-1] for name in names}
    assert {name for name in last if not re.search(rf"\b{name}\b", source)} == set()


def test_blocks_are_found() -> None:
    text = """A

.. code-block:: bash

   one
   two

.. code-block:: text
   :caption: a.b

   x

B
"""
    found = howtos.blocks(text)
    assert [(b.language, b.caption, b.text, b.line) for b in found] == [
        ("bash", "", "one\ntwo\n", 3),
        ("text", "a.b", "x\n", 8),
    ]


@pytest.mark.parametrize("page", howtos.pages())
def test_every_howto_has_something_to_do(page: str) -> None:
    if page != "howto_choices":  # numbers, no commands
        assert len(howtos.blocks((DOC / f"{page}.rst").read_text())) >= 3
