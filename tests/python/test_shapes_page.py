"""The manual's page of shapes and packings: its blocks run, and it names what there is."""

import re
import textwrap
from pathlib import Path

from peridem import packing, shapes

PAGE = (Path(__file__).resolve().parents[2] / "doc" / "shapes.rst").read_text()


def test_every_block_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"code-block:: python\n\n((?:   .*\n|\n)+)", PAGE)
    assert len(blocks) == 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(textwrap.dedent(block), names)
    # what the page makes is what it says
    assert names["loose"].smallest_gap()[0] >= 2e-4 * (1.0 - 1e-9)
    assert abs(names["loose"].fraction - 0.3) < 0.02  # half a grain of a box for sixty
    assert len(names["again"].nodes) == len(names["grain"].nodes)
    assert len(capsys.readouterr().out.splitlines()) >= 2


def test_every_shape_and_packing_is_named():
    makers = [n for n in packing.__all__ if n[0].islower() and n != "container_inside"]
    for name in [*shapes.NAMED, "polygon", "polyhedron", "stl", "regular_polygon", *makers]:
        assert f"``{name}``" in PAGE, name
