"""The command ``peridem``."""

from __future__ import annotations

import argparse
import difflib
import functools
import shlex
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from peridem import __version__

EXAMPLES = """\
examples:
  peridem mesh hexagon --radius 1e-3 --spacing 2e-4 -o hexagon.msh
  peridem run deck.yaml -np 2         read a PeriDEM deck, run it in out/deck
  peridem info out/deck               what is there, and how the run went
  peridem render out/deck --pvd       out/deck/grains.png, and grains.pvd for ParaView

exit status:
  0  done
  1  wrong input: a file, a key or a value; one line says which
  2  wrong command line
  3  LAMMPS could not be started, or failed; its message and the line of the script are shown
  130, 143  stopped by Ctrl-C (or the file 'stop'), by SIGTERM; 'peridem run --resume' goes on

'peridem COMMAND --help' shows the options of a command.
"""
RUN = """\
examples:
  peridem run in.grains -np 2         an input script, on two processes
  peridem run scene.py                a scene: what make_scene() returns, run in out/scene
  peridem run deck.yaml -o out/small --as-published
  peridem run deck2.yaml --after out/deck        a second stage, from where out/deck has ended
  peridem run in.grains --lmp lmp --var name value --quiet
  peridem run in.grains --checkpoint 1000
  mpirun -np 2 peridem run in.grains --in-process

Ctrl-C and SIGTERM stop a run within some steps and write NAME.restart; a second Ctrl-C ends it at
once. A file named 'stop' in the folder does the same as the first. Then
  peridem run in.grains --resume
goes on, with output appended. With --checkpoint N the run is cut in pieces of N steps, with a
restart file after each, and one that goes on equals one that was never stopped bit for bit.
"""
CONVERT = """\
examples:
  peridem convert deck.yaml -o out/deck
  peridem convert deck.yaml -o out/asis --as-published
  peridem convert deck2.yaml --after out/deck    a second stage: its grains as out/deck left them
  peridem convert scene.py -o out/scene
"""
MESH = """\
examples:
  peridem mesh drum --radius 1e-3 --spacing 2e-4 -o drum.msh
  peridem mesh sphere --spacing 4e-4 -o sphere.vtu
  peridem mesh circle --spacing 2e-4 --lattice hexagonal -o disc.vtu
  peridem mesh drum.msh               check a mesh, and say what it holds
"""
PLOT = """\
examples:
  peridem plot out/scene                         wall pressure against penetration
  peridem plot out/scene --wall lid -o lid.png
  peridem plot out/scene --thermo c_damage KinEng  columns of the log against time
  peridem plot out/scene --fragments             sizes of fragments at four times
"""
RENDER = """\
examples:
  peridem render out/scene                       four times, side by side
  peridem render out/scene --frames 0 2 -1       the first, the third and the last dump
  peridem render out/scene --field speed --colours magma
  peridem render out/scene --field grain --chains -o chains.png
  peridem render out/scene --film grains.mp4 --rate 10
  peridem render out/scene --pvd                 a .pvd file for ParaView as well
  peridem render out/scene --list                which fields there are

OVITO opens the dumps as they are: File, Load File, grains.dump; the columns keep their names.
"""
INFO = """\
examples:
  peridem info out/scene
  peridem info out/scene/grains.dump
  peridem info deck.yaml
"""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    about = "Granular scenes for LAMMPS with the PERIDEM package."
    main_parser = argparse.ArgumentParser(
        prog="peridem",
        description=about,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    main_parser.add_argument("--version", action="version", version=f"peridem {__version__}")
    commands = main_parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add in (_add_run, _add_convert, _add_mesh, _add_plot, _add_render, _add_info):
        add(commands)
    return main_parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status (``peridem --help`` lists them)."""
    from peridem.run import RunError

    options, rest = parser().parse_known_args(arguments)
    if rest:
        _unrecognized(options.parser, rest)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = functools.partial(_say, options.command)
            return int(options.work(options))
    except RunError as error:
        print(f"peridem {options.command}: {error}", file=sys.stderr)
        return 3
    except (ValueError, OSError, RuntimeError, KeyError) as error:
        text = error.args[0] if isinstance(error, KeyError) else error
        if isinstance(error, OSError) and error.filename and error.strerror:
            text = f"{error.filename}: {error.strerror}"
        print(f"peridem {options.command}: {text}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


def _say(
    command: str, message: Warning | str, kind: type[Warning], *_: object, **__: object
) -> None:
    """A warning as one line, without the line of the program that gave it."""
    print(f"peridem {command}: warning: {message}", file=sys.stderr)


def _unrecognized(command: argparse.ArgumentParser, words: Sequence[str]) -> NoReturn:
    """Ends with the usage of the command, and what may have been meant."""
    said = []
    for word in words:
        close = difflib.get_close_matches(word, command._option_string_actions, 1)
        said.append(f"{word} (did you mean {close[0]}?)" if close else word)
    command.error(f"unrecognized arguments: {' '.join(said)}")


# ---- options -------------------------------------------------------------------------------------


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    what: str,
    examples: str,
) -> argparse.ArgumentParser:
    made = commands.add_parser(
        name,
        help=what,
        description=what[0].upper() + what[1:] + ".",
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.set_defaults(parser=made)
    return made


def _add_run(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    run = _command(commands, "run", "run a deck, a scene or an input script", RUN)
    run.add_argument("path", type=Path, help="in.NAME or its folder, a scene (.py), a deck (.yaml)")
    run.add_argument("-np", "--ranks", type=int, default=1, help="MPI processes (1)")
    run.add_argument("-o", "--output", type=Path, help="folder for a scene or deck (out/NAME)")
    run.add_argument("--as-published", action="store_true", help="a deck as PeriDEM computes it")
    _add_after(run)
    run.add_argument("--resume", action="store_true", help="go on from the newest restart file")
    run.add_argument("--checkpoint", type=int, metavar="N", help="steps between restart files")
    run.add_argument("--lmp", type=Path, help="the LAMMPS program ($LAMMPS_LMP, build/lmp, lmp)")
    run.add_argument(
        "--var",
        nargs=2,
        action="append",
        default=[],
        metavar=("NAME", "VALUE"),
        help="a variable of the script (-var of lmp)",
    )
    run.add_argument(
        "--in-process", action="store_true", help="with the lammps module, in this Python"
    )
    run.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    run.set_defaults(work=_run)


def _add_convert(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    convert = _command(commands, "convert", "write the LAMMPS input of a deck or scene", CONVERT)
    convert.add_argument("path", type=Path, help="a deck (.yaml) or a scene (.py)")
    convert.add_argument("-o", "--output", type=Path, help="folder (out/NAME)")
    convert.add_argument(
        "--as-published", action="store_true", help="a deck as PeriDEM computes it"
    )
    _add_after(convert)
    convert.set_defaults(work=_at_once(_convert))


def _add_after(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--after",
        type=Path,
        metavar="FOLDER",
        help="begin a deck or scene where the run in FOLDER has ended",
    )


def _add_mesh(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    from peridem.shapes import NAMED

    mesh = _command(commands, "mesh", "mesh a named shape, or check a mesh file", MESH)
    mesh.add_argument("shape", help=f"{', '.join(NAMED)}, or a mesh file")
    mesh.add_argument(
        "--radius", type=float, default=1e-3, help="of the circle or sphere around it, in m (1e-3)"
    )
    mesh.add_argument(
        "--spacing",
        type=float,
        help="of the nodes, in m (a fifth of the radius); fills a surface file",
    )
    mesh.add_argument(
        "--volumes",
        default="lumped",
        choices=("lumped", "voronoi", "file"),
        help="how nodes share the cells, or as the file has them (lumped)",
    )
    mesh.add_argument(
        "--lattice",
        default="",
        choices=("square", "hexagonal", "cubic", "fcc"),
        help="the sites of a lattice instead of a mesh",
    )
    mesh.add_argument("-o", "--output", type=Path, help="file to write: .msh, .vtu, .inp, ...")
    mesh.set_defaults(work=_at_once(_mesh))


def _add_plot(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    plot = _command(commands, "plot", "plot wall pressure, thermo output or fragment sizes", PLOT)
    plot.add_argument("folder", type=Path, help="folder of the run")
    plot.add_argument("--wall", help="name of the wall, if several move")
    kind = plot.add_mutually_exclusive_group()
    kind.add_argument(
        "--thermo", nargs="+", metavar="COLUMN", help="columns of the log, against time"
    )
    kind.add_argument("--fragments", action="store_true", help="sizes of fragments")
    plot.add_argument(
        "-o", "--output", type=Path, help="picture (FOLDER/stress.png, thermo.png or fragments.png)"
    )
    plot.set_defaults(work=_plot)


def _add_render(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    render = _command(commands, "render", "draw grains; write films and ParaView files", RENDER)
    render.add_argument("folder", type=Path, help="folder of the run")
    render.add_argument(
        "--frames", type=int, nargs="+", help="numbers of dumps from 0, -1 the last (four)"
    )
    render.add_argument(
        "--field", default="damage", help="what to colour by, one of --list (damage)"
    )
    render.add_argument("--bottom", type=float, help="start of the colour scale")
    render.add_argument("--top", type=float, help="end of the colour scale (0.6 for damage)")
    render.add_argument("--colours", default="", help="a colour map of matplotlib")
    render.add_argument("--chains", action="store_true", help="draw the forces between grains")
    render.add_argument("--azimuth", type=float, help="of the camera in 3D, degrees (-60)")
    render.add_argument("--elevation", type=float, help="of the camera in 3D, degrees (20)")
    render.add_argument("-o", "--output", type=Path, help="picture (FOLDER/grains.png)")
    render.add_argument("--film", type=Path, help="write a film too: .mp4 or .gif")
    render.add_argument("--rate", type=float, default=15.0, help="film frames per second (15)")
    render.add_argument("--pvd", action="store_true", help="write FOLDER/grains.pvd too")
    render.add_argument("--list", action="store_true", help="list the fields, draw nothing")
    render.set_defaults(work=_render)


def _add_info(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    info = _command(commands, "info", "say what a file or a folder holds", INFO)
    info.add_argument("path", type=Path, help="folder, script, dump, restart, log, mesh, deck, ...")
    info.set_defaults(work=_info)


def _at_once(work: Callable[[argparse.Namespace], int]) -> Callable[[argparse.Namespace], int]:
    """Work that Ctrl-C ends at once, in the middle of gmsh too, which knows nothing of Python."""

    def ended_at_once(options: argparse.Namespace) -> int:
        before = signal.getsignal(signal.SIGINT)
        if before is not signal.default_int_handler:  # not the main program
            return work(options)
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        try:
            return work(options)
        finally:
            signal.signal(signal.SIGINT, before)

    return ended_at_once


# ---- work ----------------------------------------------------------------------------------------


def _run(options: argparse.Namespace) -> int:
    from peridem import cli_source, run

    run.check(options.ranks, options.checkpoint)
    if not options.in_process:
        run.find_lmp(options.lmp)  # before a deck is read, which may take a while
    script, said = cli_source.script_of(
        options.path, options.output, options.as_published, options.resume, options.after
    )
    for line in said:
        print(line, file=sys.stderr)
    words = {
        "quiet": options.quiet,
        "resume": options.resume,
        "checkpoint": options.checkpoint,
        "variables": dict(options.var),
    }
    try:
        if options.in_process:
            report = run.run_in_process(script, **words)
        else:
            report = run.run(script, options.ranks, options.lmp, **words)
    except run.RunError as error:
        if error.restart is None:
            raise
        again = _resuming(options, script.parent)
        hint = f"{error.restart} is where '{again}' goes on, once the cause is gone"
        raise run.RunError(f"{error}\n{hint}") from error
    if options.in_process:
        from mpi4py import MPI

        if MPI.COMM_WORLD.Get_rank() != 0:
            return 0
    how = "stopped at" if report.stopped else "reached"
    print(f"{how} step {report.steps} after {report.wall_time:.1f} s, in {script.parent}")
    if not report.stopped:
        return 0
    if report.restart:
        print(f"{report.restart} is where '{_resuming(options, script.parent)}' goes on")
    return 128 + (report.signal or signal.SIGINT)


def _resuming(options: argparse.Namespace, folder: Path) -> str:
    """The command that goes on with a run that was stopped: a deck's or scene's in its folder."""
    from peridem import cli_source

    path = folder if cli_source.is_source(options.path) else options.path
    ranks = [] if options.ranks == 1 else ["-np", str(options.ranks)]
    given = [word for name, value in options.var for word in ("--var", name, value)]
    if options.checkpoint:
        given += ["--checkpoint", str(options.checkpoint)]
    return shlex.join(["peridem", "run", str(path), *ranks, *given, "--resume"])


def _convert(options: argparse.Namespace) -> int:
    from peridem import cli_source

    folder = cli_source.folder_of(options.path, options.output)
    script, said = cli_source.convert(options.path, folder, options.as_published, options.after)
    for line in said:
        print(line, file=sys.stderr)
    print(f"written to {script}; run it with: peridem run {folder}")
    return 0


def _mesh(options: argparse.Namespace) -> int:
    from peridem import cli_info, cloud

    made = cloud.make(
        options.shape, options.radius, options.spacing, options.volumes, options.lattice
    )
    if options.output:
        made.write(options.output)
    print(cli_info.mesh_line(made))
    if options.output:
        print(f"written to {options.output}")
    return 0


def _plot(options: argparse.Namespace) -> int:
    from peridem import render

    if options.thermo:
        path = options.output or options.folder / "thermo.png"
        written = render.thermo_png(options.folder, path, options.thermo)
    elif options.fragments:
        path = options.output or options.folder / "fragments.png"
        written = render.fragments_png(options.folder, path)
    else:
        path = options.output or options.folder / "stress.png"
        written = render.stress_png(options.folder, path, options.wall)
    print(f"written to {written}")
    return 0


def _render(options: argparse.Namespace) -> int:
    from peridem import render

    if options.list:
        print("\n".join(dict.fromkeys(render.Output(options.folder).fields())))
        return 0
    camera = None
    if options.azimuth is not None or options.elevation is not None:
        chosen = {"azimuth": options.azimuth, "elevation": options.elevation}
        camera = render.Camera(**{k: v for k, v in chosen.items() if v is not None})
    look = {
        "field": options.field,
        "bottom": options.bottom,
        "top": options.top,
        "colours": options.colours,
        "chains": options.chains,
        "camera": camera,
    }
    path = options.output or options.folder / "grains.png"
    print(f"written to {render.grains_png(options.folder, path, options.frames, **look)}")
    if options.film:
        film = render.animation(
            options.folder, options.film, options.frames, rate=options.rate, **look
        )
        print(f"written to {film}")
    if options.pvd:
        print(f"written to {render.pvd(options.folder, options.folder / 'grains.pvd')}")
    return 0


def _info(options: argparse.Namespace) -> int:
    from peridem import cli_info

    print("\n".join(cli_info.info(options.path)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
