"""The Python of the manual's page of results, block after block."""

import re
from pathlib import Path

import scenes
from peridem import run, scene

PAGE = Path(__file__).resolve().parents[2] / "doc" / "results.rst"
MORE = """\
compute grain all chunk/atom molecule
compute sum all reduce/chunk grain sum c_node[4]
fix sums all ave/time 10 1 10 c_sum mode vector file per.grain
dump binary all custom 100 frames.*.bin id mol type x y
"""


def test_the_blocks_of_the_page_run(tmp_path, lmp, monkeypatch):
    folder = tmp_path / "out" / "demo"
    script = scenes.two_grains(attributes=("fragment",)).write(folder)
    text = script.read_text()
    at = re.search(r"(?m)^run ", text).start()
    script.write_text(text[:at] + MORE + text[at:])
    run.run(script, lmp=lmp, quiet=True)
    for made in [folder / "per.grain", *folder.glob("frames.*.bin")]:
        made.rename(tmp_path / made.name)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"code-block:: python\n\n((?: {3}.*\n|\n)+)", PAGE.read_text())
    assert len(blocks) == 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(re.sub(r"(?m)^ {3}", "", block), names)
    assert names["damage"].shape == (len(names["x"]),)
    assert len(names["dump"]) >= 2 and names["dump"].steps[0] == 0
    assert set(names["walls"]) >= {"TimeStep", "f_lid[2]"}
    assert names["chunks"]["c_sum"].shape[1] == 2
    assert names["pieces"].nodes.sum() == len(names["x"])
    assert (folder / scene.DUMP).is_file()
