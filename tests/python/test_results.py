"""Reading dumps, thermo output and averages."""

import gzip

import numpy as np
import pytest
import scenes
from peridem import results

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


def test_thermo_joins_the_runs_of_a_log(tmp_path):
    (tmp_path / "log").write_text(LOG)
    table = results.thermo(tmp_path / "log")
    assert list(table) == ["Step", "Time", "PotEng"]
    assert table["Step"].tolist() == [0, 10, 20, 30]
    assert table["PotEng"].tolist() == [1.5, 1.25, 1.0, 0.5]
    (tmp_path / "empty").write_text("LAMMPS\n")
    with pytest.raises(ValueError, match="no thermo output"):
        results.thermo(tmp_path / "empty")
    (tmp_path / "two").write_text(LOG + LOG.replace("PotEng", "KinEng"))
    with pytest.raises(ValueError, match="different thermo columns"):
        results.thermo(tmp_path / "two")


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
