"""The command line, run as a user runs it."""

import subprocess
import sys

import pytest
import scenes
from peridem import __version__, cloud
from peridem.cli import main


def peridem(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "peridem.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=60,
        **options,
    )


@pytest.mark.parametrize("command", [[], ["mesh"], ["run"], ["plot"], ["render"]])
def test_help_shows_examples(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*command, "--help"])
    assert ended.value.code == 0
    shown = capsys.readouterr().out
    assert "example" in shown
    assert f"  peridem {command[0] if command else 'mesh'} " in shown


def test_version_and_unknown_command():
    assert peridem("--version").stdout == f"peridem {__version__}\n"
    wrong = peridem("crush")
    assert wrong.returncode == 2 and "invalid choice: 'crush'" in wrong.stderr


def test_mesh_is_made_and_read_back(tmp_path):
    made = peridem(
        "mesh", "drum", "--radius", "1e-3", "--spacing", "2e-4", "-o", tmp_path / "drum.msh"
    )
    assert made.returncode == 0, made.stderr
    count = len(cloud.read(tmp_path / "drum.msh").nodes)
    assert made.stdout.startswith(f"drum: {count} nodes")
    again = peridem("mesh", tmp_path / "drum.msh")
    assert again.stdout.split("smallest")[0] == made.stdout.split("smallest")[0]


def test_errors_are_one_line_and_exit_1(tmp_path, capsys):
    for arguments, words in (
        (("mesh", "blob"), "no shape 'blob'"),
        (("mesh", tmp_path / "none.msh"), "no mesh file"),
        (("run", tmp_path / "in.none"), "no input script"),
        (("render", tmp_path), "scene.json"),
        (("plot", tmp_path), "scene.json"),
    ):
        assert main([str(argument) for argument in arguments]) == 1
        shown = capsys.readouterr()
        assert words in shown.err and len(shown.err.splitlines()) == 1
        assert shown.out == ""


def test_a_scene_is_run_plotted_and_drawn(tmp_path, lmp):
    scenes.two_grains().write(tmp_path)
    ran = peridem("run", tmp_path, "--lmp", lmp, "--quiet")
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith("reached step ")
    for arguments, name in ((("plot",), "stress.png"), (("render", "--pvd"), "grains.png")):
        drawn = peridem(arguments[0], tmp_path, *arguments[1:])
        assert drawn.returncode == 0, drawn.stderr
        assert (tmp_path / name).stat().st_size > 10_000
    assert (tmp_path / "grains.pvd").is_file()
