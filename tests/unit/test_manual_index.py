"""The manual's page of keywords names every keyword with its page and its tests."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOC, TESTS = ROOT / "doc", ROOT / "tests"


@dataclass(frozen=True)
class Row:
    words: tuple[str, ...]
    page: str
    tests: tuple[str, ...]


def rows() -> list[Row]:
    text = (DOC / "keywords.rst").read_text()
    found = []
    for cells in re.findall(r"\* - (.*)\n\s+- (.*)\n\s+- (.*)\n", text)[1:]:
        words, page, tests = cells
        literal = r"``([^`]+)``"
        target = re.search(r"<(\w+)>", page)
        assert target, page
        found.append(
            Row(
                tuple(re.findall(literal, words)),
                target.group(1),
                tuple(re.findall(literal, tests)),
            )
        )
    return found


ROWS = rows()


def parsed_words() -> set[str]:
    """Words that the C++ compares input with, and the tables of words that it looks them up in."""
    compared = re.compile(
        r'(?:key|value|arg\[[^\]]*\]) == "([a-z]\w*)"|strcmp\(arg\[[^\]]*\], "([a-z]\w*)"\)'
    )
    tables = re.compile(r"(?:modulus_names|field_names)\b[^;=]*=?\s*\{([^}]*)\}")
    words = set()
    for path in (ROOT / "src" / "PERIDEM").glob("*.cpp"):
        text = path.read_text()
        words |= {one or other for one, other in compared.findall(text)}
        for table in tables.findall(text):
            words |= set(re.findall(r'"(\w+)"', table))
    return words


def documented_words() -> set[str]:
    """Keywords of the Syntax sections: the first word of each line of their parsed literals."""
    words = set()
    for path in DOC.glob("*_peridem_*.rst"):
        syntax = path.read_text().split("\nExamples\n")[0]
        words |= set(re.findall(r"^\s{4,}\*([a-z]\w*)\*", syntax, re.M))
    return words


def test_the_table_was_found():
    assert len(ROWS) > 20
    assert len(parsed_words()) > 40
    assert len(documented_words()) > 30


@pytest.mark.parametrize("source", [parsed_words, documented_words])
def test_every_keyword_is_on_the_page(source):
    listed = {word for row in ROWS for word in row.words}
    missing = source() - listed
    assert not missing


def test_every_style_has_a_row():
    pages = {path.stem for path in DOC.glob("*_peridem*.rst") if not path.stem.startswith("howto")}
    assert {row.page for row in ROWS} == pages


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.page}: {' '.join(row.words)}")
def test_pages_and_tests_exist_and_have_the_words(row):
    page = (DOC / f"{row.page}.rst").read_text()
    assert row.tests
    text = ""
    for name in row.tests:
        assert (TESTS / name).is_file(), name
        text += (TESTS / name).read_text()
    # helpers of the tests write some of the words (lps_words, contact_words)
    text += (TESTS / "support" / "runs.py").read_text()
    for word in row.words:
        assert re.search(rf"\*{word}\*|\b{word}\b", page), f"{row.page} lacks {word}"
        assert re.search(rf"\b{word}\b", text), f"no test of {row.tests} has {word}"
