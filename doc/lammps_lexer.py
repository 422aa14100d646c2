"""Colours for input scripts of LAMMPS in the manual (``.. code-block:: LAMMPS``)."""

from __future__ import annotations

from pygments.lexer import RegexLexer, bygroups
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
    Whitespace,
)

# these name something, or a group it acts on, before the style comes
WITH_ID = ("compute", "dump", "fix", "group", "region", "variable")


class LammpsLexer(RegexLexer):
    """The first word of a line is a command; what follows are names, numbers and words."""

    name = "LAMMPS"
    aliases = ("LAMMPS", "lammps")
    filenames = ("in.*",)

    tokens = {  # noqa: RUF012 (pygments reads it from the class)
        "root": [
            (r"\s+", Whitespace),
            (r"#.*$", Comment.Single),
            (
                rf"({'|'.join(WITH_ID)})([ \t]+)([\w-]+)",
                bygroups(Keyword, Whitespace, Name.Variable),
                "arguments",
            ),
            (r"[a-zA-Z]\w*", Keyword, "arguments"),
            (r".", Text, "arguments"),
        ],
        "arguments": [
            (r"&[ \t]*\n", Punctuation),
            (r"\n", Whitespace, "#pop"),
            (r"[ \t]+", Whitespace),
            (r"#.*$", Comment.Single),
            (r"\$\{[^}]*\}|\$\([^)]*\)|\$\w", Name.Variable),
            (r"\b[vfc]_[\w-]+", Name.Variable),
            (r'"[^"]*"|\'[^\']*\'', String),
            (r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w/.])", Number),
            (r"[a-z]+(?:/[a-z]+)+", Name.Function),
            (r"[A-Za-z][\w./-]*", Name),
            (r"[-+*/^=<>()\[\],:]", Operator),
            (r".", Text),
        ],
    }
