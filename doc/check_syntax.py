"""Checks the Syntax sections of the manual against what the program says that it knows.

    python doc/check_syntax.py [lmp]

Each style is given a keyword, and each keyword that chooses between words a word, that does not
exist: the error names those that are known.  They have to be the ones of the page, all of them and
no others.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from check_pages import DOC, PAIR, SCENE

WRONG = "nonsense"
SOLID = "pair_style peridem/{}\npair_coeff * * {} " + WRONG
TOUCH = "pair_style peridem/contact\npair_coeff * * {} " + WRONG
WALL = PAIR + "fix one all peridem/wall {} " + WRONG


@dataclass(frozen=True)
class Question:
    """What to ask the program, and where on a page the answer stands.

    Attributes:
        page: without .rst.
        keyword: whose words are asked for; nothing: keywords of the command itself.
        line: of a script, ending with a word that is none.
        others: keywords that the page names in its Syntax, of another command than this one.
    """

    page: str
    keyword: str
    line: str
    others: frozenset[str] = frozenset()


def questions() -> list[Question]:
    solids = ("lps", "pmb")
    found = [
        Question(f"pair_peridem_{one}", "", SOLID.format(one, ""), frozenset({"engine"}))
        for one in solids
    ]
    found.append(Question("pair_peridem_lps", "engine", f"pair_style peridem/lps engine {WRONG}"))
    for word in ("influence", "plane", "volume", "break"):
        found.append(Question("pair_peridem_lps", word, SOLID.format("lps", word)))
    for word in ("plane", "potential"):
        found.append(Question("pair_peridem_pmb", word, SOLID.format("pmb", word)))
    found.append(Question("pair_peridem_contact", "", TOUCH.format("")))
    for word in ("form", "tangential"):
        found.append(Question("pair_peridem_contact", word, TOUCH.format(word)))
    for style in ("bonds", "timestep", "adapt"):
        line = PAIR + f"fix one all peridem/{style} {WRONG} 1"
        found.append(Question(f"fix_peridem_{style}", "", line))
    line = PAIR + "fix one all peridem/{} {} " + WRONG
    found.append(Question("fix_peridem_bonds", "cut", line.format("bonds", "cut")))
    found.append(Question("fix_peridem_adapt", "start", line.format("adapt", "start")))
    found.append(Question("fix_peridem_wall", "", WALL.format("plane 0 0 0 0 1 0")))
    found.append(Question("fix_peridem_wall", "surface", WALL.format("")))
    line = PAIR + f"compute one all peridem/atom {WRONG}"
    found.append(Question("compute_peridem_atom", "", line))
    return found


def answer(line: str, lmp: str) -> str:
    """The error of a script with one wrong word."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in").write_text(f"{SCENE}{line}\n")
        command = [lmp, "-in", "in", "-nocite", "-log", "none"]
        run = subprocess.run(command, cwd=folder, text=True, capture_output=True)
    errors = re.findall(r"^ERROR: (.*?)(?: \([^()]*:\d+\))?$", run.stdout, re.MULTILINE)
    if len(errors) != 1 or WRONG not in errors[0]:
        raise RuntimeError(f"no error about {WRONG}:\n{line}\n{run.stdout[-1500:]}")
    return str(errors[0])


def known(error: str) -> set[str]:
    """The words behind 'known are' or 'must be', without what follows each of them."""
    listed = re.split(r": (?:known are|known is|must be) ", error)[1]
    return {re.split(r"[ \[]", one)[0] for one in re.split(r", or |, | or ", listed)}


def syntax(page: str) -> str:
    text = (DOC / f"{page}.rst").read_text()
    return text.split("\nSyntax\n")[1].split("\nExamples\n")[0]


def described(page: str, keyword: str) -> set[str]:
    """Keywords that the Syntax section of a page explains, or the words that one of them takes."""
    text = syntax(page)
    if keyword:
        lines = re.findall(rf"^\W*{keyword}\W* (?:values? )?= (.*)$", text, re.MULTILINE)
        if len(lines) != 1:
            raise RuntimeError(f"{page}.rst: {len(lines)} lines say what {keyword} is")
        # a word in brackets belongs to the one before it
        return set(re.findall(r"\*(\w+)\*", re.sub(r"\[[^]]*\]", "", lines[0])))
    attributes = re.findall(r"^\* attribute = (.*)$", text, re.MULTILINE)
    if attributes:
        return set(re.findall(r"\*(\w+)\*", attributes[0]))
    starts = re.findall(r"^ {5,7}((?:\*\w+\*(?:, | or )?)+)", text, re.MULTILINE)
    return {word for start in starts for word in re.findall(r"\*(\w+)\*", start)}


def listed(page: str) -> set[str] | None:
    """The keywords of the line '* keyword = ...', if the page has one."""
    lines = re.findall(r"^\* keyword = (.*)$", syntax(page), re.MULTILINE)
    return set(re.findall(r"\*(\w+)\*", lines[0])) if lines else None


def differences(question: Question, lmp: str) -> str:
    """What a page lacks, and what the program does not know: nothing if they agree."""
    program = known(answer(question.line, lmp))
    page = described(question.page, question.keyword) - question.others
    found = [f"lacks {word}" for word in sorted(program - page)]
    found += [f"has {word}, which the program does not know" for word in sorted(page - program)]
    keywords = None if question.keyword else listed(question.page)
    if keywords is not None and keywords != program:
        found.append(f"'* keyword =' differs in {sorted(keywords ^ program)}")
    return f"{question.page}.rst {question.keyword}: {'; '.join(found)}" if found else ""


def main() -> int:
    lmp = sys.argv[1] if len(sys.argv) > 1 else str(DOC.parent / "build" / "lmp")
    asked = questions()
    wrong = [text for text in (differences(one, lmp) for one in asked) if text]
    print("\n".join([*wrong, f"syntax: {len(asked)} lists of words compared"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
