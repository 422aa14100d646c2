"""Reading dumps, thermo output and averages."""

import gzip
import subprocess

import numpy as np
import pytest
import scenes
from peridem import cloud, results, scene, shapes
from peridem.material import Contact, Inert, Material

COLUMNS = "id mol type x y vx vy"
ROWS = np.array([(2, 1, 1, 0.5, 0.6, 0, 0), (1, 1, 1, 0.1, 0.2, 1, 2), (3, 2, 1, 0.9, 1.9, 0, 0)])


def test_dump_is_read_frame_by_frame_in_the_order_of_ids(tmp_path):
    moved = ROWS + np.array([0, 0, 0, 0.01, 0, 0, 0])
    scenes.write_dump(tmp_path / "a.dump", [(0, ROWS), (50, moved)], COLUMNS)
    dump = results.Dump(tmp_path / "a.dump")
    assert len(dump) == 2 and dump.steps.tolist() == [0, 50]
    assert dump[0]["id"].tolist() == [1, 2, 3]
    assert dump[0].position == pytest.approx(np.array([(0.1, 0.2), (0.5, 0.6), (0.9, 1.9)]))
    assert dump[-1]["x"] == pytest.approx([0.11, 0.51, 0.91])
    assert dump[0].box == pytest.approx(np.array([(0, 1), (0, 2), (-0.5, 0.5)]))
    assert [frame.step for frame in dump] == [0, 50]
    assert dump.nearest(30) == 1
    with pytest.raises(KeyError, match="no column 'fx'"):
        dump[0]["fx"]
    with pytest.raises(IndexError):
        dump[2]


def test_compressed_dump_reads_the_same(tmp_path):
    scenes.write_dump(tmp_path / "a.dump", [(0, ROWS), (50, ROWS)], COLUMNS)
    with gzip.open(tmp_path / "a.dump.gz", "wb") as file:
        file.write((tmp_path / "a.dump").read_bytes())
    plain, packed = results.Dump(tmp_path / "a.dump"), results.Dump(tmp_path / "a.dump.gz")
    assert packed.steps.tolist() == plain.steps.tolist()
    for name, values in plain[1].columns.items():
        assert (packed[1][name] == values).all()


@pytest.mark.parametrize(
    "cut", ["ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n", "ITEM: TIMESTEP\n"]
)
def test_a_frame_that_is_being_written_is_left_out(tmp_path, cut):
    scenes.write_dump(tmp_path / "a.dump", [(0, ROWS)], COLUMNS, cut)
    assert results.Dump(tmp_path / "a.dump").steps.tolist() == [0]


def test_a_last_line_that_is_being_written_is_left_out(tmp_path):
    scenes.write_dump(tmp_path / "a.dump", [(0, ROWS), (50, ROWS)], COLUMNS)
    (tmp_path / "b.dump").write_text((tmp_path / "a.dump").read_text()[:-3])
    assert results.Dump(tmp_path / "b.dump").steps.tolist() == [0]


def test_what_is_no_dump_is_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="none"):
        results.Dump(tmp_path / "none")
    (tmp_path / "text").write_text("LAMMPS data file\n")
    with pytest.raises(ValueError, match="LAMMPS data file"):
        results.Dump(tmp_path / "text")


LOG = """\
LAMMPS (4 Jul 2026)
run 20
   Step          Time          PotEng
         0   0              1.5
        10   1e-3           1.25
WARNING: something happened here
        20   2e-3           1
Loop time of 1 on 1 procs for 20 steps with 5 atoms
run 10
   Step          Time          PotEng
        20   2e-3           1
        30   3e-3           0.5
Loop time of 1 on 1 procs for 10 steps with 5 atoms
       999   this is not thermo output
"""


def test_binary_and_compressed_binary_dumps_read_as_text_does(tmp_path, lmp):
    """One frame through all three writers of LAMMPS, with a direction that repeats and the time."""
    columns = "id mol type x y vx c_q"
    dumps = {name: tmp_path / name for name in ("a.dump", "a.bin", "a.dump.gz")}
    lines = [
        f"dump d{k} all custom 5 {name} {columns}\ndump_modify d{k} time yes units yes"
        for k, name in enumerate(dumps)
    ]
    lines += [f"dump_modify d{k} format float %.17g" for k in (0, 2)]
    (tmp_path / "in.x").write_text(SMALL + "\n".join(lines) + "\nrun 10\n")
    subprocess.run([lmp, "-in", "in.x", "-screen", "none"], cwd=tmp_path, check=True, timeout=60)
    text, *others = (results.Dump(path) for path in dumps.values())
    assert text.steps.tolist() == [0, 5, 10]
    for other in others:
        assert other.steps.tolist() == text.steps.tolist()
        for one, two in zip(text, other, strict=True):
            assert two.periodic == one.periodic == (True, False, True)
            assert two.time == pytest.approx(one.time) == 0.002 * one.step
            assert two.box == pytest.approx(one.box)
            assert list(two.columns) == list(one.columns)
            for name in one.columns:
                assert (two[name] == one[name]).all(), name
    (tmp_path / "a.bin").write_bytes((tmp_path / "a.bin").read_bytes()[:-8])
    assert results.Dump(tmp_path / "a.bin").steps.tolist() == [0, 5]
    (tmp_path / "a.dump.gz").write_bytes((tmp_path / "a.dump.gz").read_bytes()[:-60])
    assert results.Dump(tmp_path / "a.dump.gz").steps.tolist() in ([0, 5], [0])
    (tmp_path / "no.bin").write_bytes(bytes(200))
    with pytest.raises(ValueError, match="not a binary dump"):
        results.Dump(tmp_path / "no.bin")


def test_a_file_for_each_time(tmp_path):
    for step in (0, 50, 100):
        scenes.write_dump(tmp_path / f"a.{step}.dump", [(step, ROWS)], COLUMNS)
    dump = results.Dump(tmp_path / "a.*.dump")
    assert dump.steps.tolist() == [0, 50, 100]
    assert dump[2]["x"].tolist() == [0.1, 0.5, 0.9]


SMALL = """\
units lj
dimension 2
boundary p f p
atom_style peridem
lattice sq 1.0
region box block 0 6 0 6 -0.5 0.5
create_box 1 box
create_atoms 1 box
set group all mol 1
set group all volume 1.0
set group all density 1.0
neighbor 0.3 bin
pair_style peridem/lps
pair_coeff * * bulk 10 shear 6 unbreakable horizon 2.3
velocity all create 0.1 5 dist uniform
compute q all property/atom fx
fix motion all nve
timestep 0.002
"""


def test_thermo_joins_the_runs_of_a_log(tmp_path):
    (tmp_path / "log").write_text(LOG)
    table = results.thermo(tmp_path / "log")
    assert list(table) == ["Step", "Time", "PotEng"]
    assert table["Step"].tolist() == [0, 10, 20, 30]
    assert table["PotEng"].tolist() == [1.5, 1.25, 1.0, 0.5]
    (tmp_path / "empty").write_text("LAMMPS\n")
    with pytest.raises(ValueError, match="no thermo output"):
        results.thermo(tmp_path / "empty")
    other = "   Step          KinEng\n        40   2.5\nLoop time of 1\n"
    (tmp_path / "two").write_text(LOG + other)
    table = results.thermo(tmp_path / "two")
    assert table["Step"].tolist() == [0, 10, 20, 30, 40]
    assert np.isnan(table["KinEng"]).tolist() == [True, True, True, True, False]


def test_of_a_resumed_run_the_later_lines_count(tmp_path):
    lines = "0 0 4\n10 1 3\n20 2 2\n"
    end = "Loop time of 1\n"
    again = f"Step Time E\n{lines}Step Time E\n10 1 5\n20 2 6\n{end}Step Time E\n20 2 7\n30 3 8.5"
    (tmp_path / "log").write_text(again)
    # the last line has no end: it may be 8.57
    assert results.thermo(tmp_path / "log")["E"].tolist() == [4, 5, 7]
    head = "# Time-averaged data for fix a\n# TimeStep f_a\n"
    (tmp_path / "a").write_text(f"{head}10 1\n20 2\n30 3\n{head}20 5\n30 6\n40 7")
    assert results.averages(tmp_path / "a")["f_a"].tolist() == [1, 5, 6]


def test_vectors_and_chunks(tmp_path):
    head = "# Chunk-averaged data for fix a\n# Timestep Number-of-chunks Total-count\n"
    head += "# Chunk Coord1 vx\n"
    (tmp_path / "c").write_text(head + "10 2 5\n1 0.1 3\n2 0.2 4\n20 2 5\n1 0.1 6\n2 0.2 7\n30 2")
    chunks = results.vectors(tmp_path / "c")
    assert chunks.steps.tolist() == [10, 20]
    assert chunks["vx"].tolist() == [[3, 4], [6, 7]]
    with pytest.raises(KeyError, match="no column 'vy'; there are Chunk, Coord1, vx"):
        chunks["vy"]
    head = "# Time-averaged data for fix a\n# TimeStep Number-of-rows\n# Row c_a\n"
    (tmp_path / "v").write_text(head + "10 2\n1 0.5\n2 0.7\n")
    assert results.vectors(tmp_path / "v")["c_a"].tolist() == [[0.5, 0.7]]
    with pytest.raises(ValueError, match=r"read it with results\.vectors"):
        results.averages(tmp_path / "v")


def test_averages(tmp_path):
    head = "# Time-averaged data for fix walls\n# TimeStep v_lid_travel f_lid[1]\n"
    (tmp_path / "walls.dat").write_text(head + "10 1e-5 3\n20 2e-5 4\n")
    table = results.averages(tmp_path / "walls.dat")
    assert table["TimeStep"].tolist() == [10, 20]
    assert table["f_lid[1]"].tolist() == [3.0, 4.0]


def test_means_over_grains(tmp_path):
    scenes.write_dump(tmp_path / "a.dump", [(0, ROWS)], COLUMNS)
    frame = results.Dump(tmp_path / "a.dump")[0]
    grains, centres = results.per_grain(frame)
    assert grains.tolist() == [1, 2]
    assert centres == pytest.approx(np.array([(0.3, 0.4), (0.9, 1.9)]))
    assert results.per_grain(frame, frame["vx"])[1] == pytest.approx([0.5, 0.0])


def test_cells_of_bodies_without_bonds_stay(tmp_path):
    """Each node of such a body is a fragment of its own."""
    disc = cloud.mesh(shapes.circle(1e-3), 4e-4)
    solid = Material(bulk=2e7, poisson=0.25, density=1000.0, horizon=1e-3, gc=5.0)
    wall = scene.Grain(disc.moved((5e-3, 0.0)), Inert(1000.0, "wall"))
    made = scene.Scene("wall of nodes", [scene.Grain(disc, solid), wall], Contact(), 1e-5)
    made.write(tmp_path)
    x, n = made.reference, len(disc.nodes)
    kinds = made.type_of_node
    piece = [1] * n + list(range(n + 1, 2 * n + 1))
    rows = [(k + 1, made.grain_of_node[k], kinds[k], *x[k], piece[k]) for k in range(2 * n)]
    scenes.write_dump(tmp_path / scene.DUMP, [(0, rows)], "id mol type x y c_node[1]")
    output = results.Output(tmp_path)
    output.attributes = {"fragment": "c_node[1]"}
    assert len(output.intact_cells(0)) == len(output.cells)
