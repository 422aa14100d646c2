"""Settings of the manual: ``make docs`` builds it with Sphinx into build/docs/html."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxTranslator

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

import peridem  # noqa: E402
from lammps_lexer import LammpsLexer  # noqa: E402

project = "PERIDEM"
author = "the PERIDEM developers"
copyright = author
release = version = peridem.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
]
exclude_patterns = ["_build"]
nitpicky = False
keep_warnings = True

# ---- pages ---------------------------------------------------------------------------------------

html_theme = "furo"
html_title = f"PERIDEM {release}"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "default"
pygments_dark_style = "monokai"
highlight_language = "none"
myst_heading_anchors = 3
myst_enable_extensions = ["html_image"]

# what a copy button copies: commands without their prompt
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True

# ---- the Python package --------------------------------------------------------------------------

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True}
# by their names in the sources: what is in them is said in words
arrays = ("Array", "Ints", "Flags", "Mask", "Cells", "Triangles", "Shape", "Box", "Orientation")
autodoc_type_aliases = {name: name for name in (*arrays, "ArrayLike", "AnyMaterial", "AnyWall")}
napoleon_use_ivar = True
napoleon_attr_annotations = False  # types stand in the signature
toc_object_entries_show_parents = "hide"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88


def readable(
    _app: Sphinx, _what: str, _name: str, _obj: object, _options: object, text: str, back: str
) -> tuple[str, str]:
    """Signatures that Sphinx can read: defaults that a function makes are shown as dots."""
    return (text or "").replace("<factory>", "..."), back


# ---- pages of LAMMPS's own manual ----------------------------------------------------------------

# The pages of styles name them as they would upstream, where they lie in the same folder.
LAMMPS_MANUAL = "https://docs.lammps.org"
LAMMPS_PAGES = (HERE / "lammps_pages.txt").read_text().split()


def lammps_page(
    _app: Sphinx, _env: BuildEnvironment, node: pending_xref, text: nodes.TextElement
) -> nodes.reference | None:
    """What ``:doc:`` names and is no page of ours: an address, if it is one of LAMMPS's."""
    if node["reftype"] != "doc" or node["reftarget"] not in LAMMPS_PAGES:
        return None  # Sphinx warns
    address = f"{LAMMPS_MANUAL}/{node['reftarget']}.html"
    return nodes.reference("", "", text, internal=False, refuri=address)


# ---- make linkcheck ------------------------------------------------------------------------------

linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_workers = 4

# ---- formulas as MathML, which browsers draw by themselves: no script, no network ----------------

html_math_renderer = "mathml"
FUNCTIONS = r"\\(?:arcsin|arccos|sin|cos|tan|cot|ln)\b"


def mathml(text: str, block: bool) -> str:
    text = re.sub(r"\\([td]?frac)(\d)(\d)", r"\\\1{\2}{\3}", text)  # what docutils misreads
    text = re.sub(rf"(?<=[\w}}]) ({FUNCTIONS})", r"\\, \1", text)  # spaces that browsers leave out
    text = re.sub(rf"({FUNCTIONS})(?= *[\w\\](?!left))", r"\1\\,", text)
    if "\\\\" in text and "\\begin{" not in text.split("\\\\")[0]:
        text = rf"\begin{{aligned}}{text}\end{{aligned}}"
    return tex2mathml(text, as_block=block)


def inline_formula(self: SphinxTranslator, node: nodes.math) -> None:
    self.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def formula(self: SphinxTranslator, node: nodes.math_block) -> None:
    self.body.append(f'<div class="formula">{mathml(node.astext(), block=True)}</div>')
    raise nodes.SkipNode


# ---- tables --------------------------------------------------------------------------------------


NUMBER = r"([≤≥<>±] ?)?[-−]?[\d.]+(e[-+]?\d+)?( %)?|\d to \d"  # or numbers of a vector


def mark_tables(_app: Sphinx, page: nodes.document) -> None:
    """Marks tables of many columns, of rows with long names, and cells that hold one number,
    which browsers would break at the sign of its exponent.
    """
    for group in page.findall(nodes.tgroup):
        if group["cols"] > 8:
            group.parent["classes"].append("wide")
        first = [row[0].astext() for row in group.findall(nodes.row)]
        if group["cols"] > 6 and max(map(len, first)) > 20:
            group.parent["classes"].append("named")
    for cell in page.findall(nodes.entry):
        if re.fullmatch(NUMBER, cell.astext().strip()):
            cell["classes"].append("number")


# ---- pages in plain Markdown ---------------------------------------------------------------------

INCLUDE = r"(?m)^```\{include\} (\S+)\n```$"


def pages_of_files() -> dict[Path, Path]:
    """Files from elsewhere in the repository, and the pages that include them."""
    found = {}
    for page in HERE.rglob("*.md"):
        for name in re.findall(INCLUDE, page.read_text()):
            found[(page.parent / name).resolve()] = page
    return found


def included(page: Path, path: Path) -> str:
    """A file from elsewhere in the repository, its links turned so that they hold on the page."""
    pages = pages_of_files()

    def turned(link: re.Match[str]) -> str:
        start, target, end = link.groups()
        if "://" in target or target.startswith("#"):
            return link[0]
        there = (path.parent / target).resolve()
        readme = there / "README.md" if there.is_dir() else there
        there = pages.get(readme, there)
        return start + os.path.relpath(there, page.parent) + end

    text = re.sub(r"(\]\()([^)\s]+)(\))", turned, path.read_text())
    text = re.sub(r'(src=")([^"]+)(")', turned, text)
    if path.parent.parent.name == "examples":  # below its title: where it is
        text = text.replace("\n", f"\n\nIn the folder `examples/{path.parent.name}`:\n", 1)
    return text


def read_markdown(app: Sphinx, name: str, text: list[str]) -> None:
    """Puts included files in place, and makes anchors of plain Markdown targets of Sphinx."""
    page = Path(app.env.doc2path(name))
    if page.suffix != ".md":
        return

    def put(directive: re.Match[str]) -> str:
        path = (page.parent / directive[1]).resolve()
        app.env.note_dependency(str(path))
        return included(page, path)

    text[0] = re.sub(INCLUDE, put, text[0])
    text[0] = re.sub(r'(?m)^(#+ .*)\n<a id="([\w-]+)"></a>$', r"(\2)=\n\1", text[0])


def setup(app: Sphinx) -> None:
    app.add_lexer("LAMMPS", LammpsLexer)
    app.add_html_math_renderer("mathml", (inline_formula, None), (formula, None))
    app.connect("source-read", read_markdown)
    app.connect("doctree-read", mark_tables)
    app.connect("autodoc-process-signature", readable)
    app.connect("missing-reference", lammps_page)
