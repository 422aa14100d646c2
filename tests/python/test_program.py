"""`peridem.program`: options of programs that make and run scenes, and how they end."""

from __future__ import annotations

from pathlib import Path

import pytest
from peridem import program
from peridem.run import RunError, RunReport

SCRIPT = "units lj\natom_style peridem\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\n{}\n"


@pytest.fixture
def choose(tmp_path, lmp):
    """Options of a program, as its user gave them."""

    def options(*words: str, **more):
        made = program.options("Makes a heap.\n\nMore.", str(tmp_path), small="less", **more)
        return made.parse_args([*words, "--lmp", str(lmp)])

    return options


def scripts(folder: Path, *last: str) -> list[Path]:
    paths = []
    for k, line in enumerate(last):
        path = folder / str(k) / "in.scene"
        path.parent.mkdir()
        path.write_text(SCRIPT.format(line))
        paths.append(path)
    return paths


def test_options_are_the_usual_ones(capsys):
    made = program.options("Makes a heap.\n\nMore.", "out/heap", small="fewer grains")
    chosen = made.parse_args(["--small", "-np", "3"])
    assert (chosen.small, chosen.ranks, chosen.output) == (True, 3, Path("out/heap"))
    assert made.description == "Makes a heap."
    side = program.options(None, "out/heap", side_by_side=True).parse_args([])
    assert side.at_once == 2 and not hasattr(side, "ranks") and not hasattr(side, "small")
    with pytest.raises(SystemExit) as ended:
        program.options(None, "out/heap").parse_args(["--small"])
    assert ended.value.code == 2 and "--small" in capsys.readouterr().err


def test_no_run_says_how_to_run_each(choose, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        program.run([tmp_path / "a" / "in.a", tmp_path / "b" / "in.b"], choose("--no-run"))
    assert ended.value.code == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].endswith(f"peridem run {tmp_path / 'a'} -np 2") and len(said) == 2


@pytest.mark.parametrize("side_by_side", [False, True])
def test_runs_all(choose, tmp_path, side_by_side):
    two = scripts(tmp_path, "pair_style none\nrun 3", "pair_style none\nrun 4")
    reports = program.run(two, choose("-np", "1", side_by_side=side_by_side))
    assert [report.steps for report in reports] == [3, 4]


@pytest.mark.parametrize("side_by_side", [False, True])
def test_a_failure_ends_the_program_with_its_message(choose, tmp_path, side_by_side):
    [script] = scripts(tmp_path, "pair_style none\nrun 3 evry 2 NULL")
    with pytest.raises(SystemExit) as ended:
        program.run(script, choose("-np", "1", side_by_side=side_by_side))
    assert isinstance(ended.value.code, str) and "evry" in ended.value.code
    assert isinstance(ended.value.__cause__, RunError)


def test_a_failure_says_where_the_run_can_go_on(choose, tmp_path):
    two = "pair_style none\nrun 3\nwrite_restart one.restart\nrun 3 evry 2 NULL"
    [script] = scripts(tmp_path, two)
    with pytest.raises(SystemExit) as ended:
        program.run(script, choose("-np", "1"))
    assert str(ended.value.code).endswith(
        f"once the cause is gone, go on with: peridem run {tmp_path / '0'} --resume"
    )


def test_a_stop_ends_it_with_the_status_of_shells_and_starts_no_more(
    choose, tmp_path, capsys, monkeypatch
):
    started = []

    def stopped(script, ranks, lmp):
        started.append(script)
        return RunReport(7, 0.1, True)

    monkeypatch.setattr("peridem.run.run", stopped)
    two = scripts(tmp_path, "run 3", "run 3")
    with pytest.raises(SystemExit) as ended:
        program.run(two, choose())
    assert ended.value.code == program.STOPPED == 130
    assert started == two[:1]
    assert f"stopped at step 7; go on with: peridem run {tmp_path / '0'} --resume" in (
        capsys.readouterr().err
    )
