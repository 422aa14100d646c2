"""The command ``peridem``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from peridem import __version__

EXAMPLES = """\
examples:
  peridem mesh hexagon --radius 1e-3 --spacing 2e-4 -o hexagon.msh
  peridem run out/demo -np 2          run the input script of a folder on two processes
  peridem plot out/demo               wall pressure against penetration: out/demo/stress.png
  peridem render out/demo --pvd       out/demo/grains.png, and grains.pvd for ParaView

'peridem COMMAND --help' shows the options of a command.
"""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    about = "Granular scenes for LAMMPS with the PERIDEM package."
    main_parser = _parser("peridem", about, EXAMPLES)
    main_parser.add_argument("--version", action="version", version=f"peridem {__version__}")
    commands = main_parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    mesh = _command(
        commands,
        "mesh",
        "mesh a named shape, or check a mesh file",
        "examples:\n"
        "  peridem mesh drum --radius 1e-3 --spacing 2e-4 -o drum.msh\n"
        "  peridem mesh grain.msh              check a mesh, and say what it holds\n",
    )
    mesh.add_argument("shape", help="circle, hexagon, triangle, drum, or a mesh file")
    mesh.add_argument("--radius", type=float, default=1e-3, help="of the circle around it (1e-3)")
    mesh.add_argument("--spacing", type=float, help="of the nodes (a fifth of the radius)")
    mesh.add_argument("-o", "--output", type=Path, help="file to write: .msh, .vtu, .inp, ...")
    mesh.set_defaults(work=_mesh)

    run = _command(
        commands,
        "run",
        "run an input script, with progress and a clean stop on Ctrl-C",
        "examples:\n"
        "  peridem run out/demo -np 2\n"
        "  peridem run in.grains --lmp /opt/lammps/bin/lmp\n"
        "  mpirun -np 2 peridem run in.grains --in-process\n",
    )
    run.add_argument("script", type=Path, help="the script, or its folder")
    run.add_argument("-np", "--ranks", type=int, default=1, help="MPI processes (1)")
    run.add_argument("--lmp", type=Path, help="the lmp program")
    run.add_argument("--in-process", action="store_true", help="with the lammps module")
    run.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    run.set_defaults(work=_run)

    plot = _command(
        commands,
        "plot",
        "plot the pressure on a moving wall against its penetration",
        "example:\n  peridem plot out/demo -o stress.png\n",
    )
    plot.add_argument("folder", type=Path, help="of the run")
    plot.add_argument("--wall", help="its name, if several move")
    plot.add_argument("-o", "--output", type=Path, help="picture (FOLDER/stress.png)")
    plot.set_defaults(work=_plot)

    render = _command(
        commands,
        "render",
        "draw grains coloured by damage; write a time series for ParaView",
        "examples:\n"
        "  peridem render out/demo                    four times, side by side\n"
        "  peridem render out/demo --frames 0 50 -1   the first, the 51st and the last dump\n"
        "  peridem render out/demo --pvd              a .pvd file as well\n",
    )
    render.add_argument("folder", type=Path, help="of the run")
    render.add_argument("--frames", type=int, nargs="+", help="numbers of dumps (four, spread)")
    render.add_argument("--top", type=float, default=0.6, help="end of the colour scale (0.6)")
    render.add_argument("-o", "--output", type=Path, help="picture (FOLDER/grains.png)")
    render.add_argument("--pvd", action="store_true", help="write FOLDER/grains.pvd too")
    render.set_defaults(work=_render)
    return main_parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status: 0, 1 after an error, 130 when stopped."""
    options = parser().parse_args(arguments)
    try:
        return int(options.work(options))
    except (ValueError, OSError, RuntimeError, KeyError) as error:
        text = error.args[0] if isinstance(error, KeyError) else error
        print(f"peridem {options.command}: {text}", file=sys.stderr)
        return 1


def _parser(name: str, description: str, examples: str) -> argparse.ArgumentParser:
    return argparse.ArgumentParser(
        prog=name,
        description=description,
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    what: str,
    examples: str,
) -> argparse.ArgumentParser:
    return commands.add_parser(
        name,
        help=what,
        description=what[0].upper() + what[1:] + ".",
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _mesh(options: argparse.Namespace) -> int:
    from peridem import cloud, shapes

    named = {s.__name__: s for s in (shapes.circle, shapes.hexagon, shapes.triangle, shapes.drum)}
    if options.shape in named:
        outline = named[options.shape](options.radius)
        made = cloud.mesh(outline, options.spacing or options.radius / 5.0)
    elif Path(options.shape).suffix:
        made = cloud.read(options.shape)
    else:
        raise ValueError(f"no shape '{options.shape}': {', '.join(named)}, or a mesh file")
    what = "area" if made.dimension == 2 else "volume"
    print(
        f"{made.name}: {len(made.nodes)} nodes ({made.surface.sum()} on the boundary), "
        f"{len(made.cells)} cells, {what} {made.volumes.sum():.6g}, "
        f"smallest spacing {made.spacing:.4g}"
    )
    if options.output:
        made.write(options.output)
        print(f"written to {options.output}")
    return 0


def _run(options: argparse.Namespace) -> int:
    from peridem import run

    if options.in_process:
        report = run.run_in_process(options.script, quiet=options.quiet)
        from mpi4py import MPI

        if MPI.COMM_WORLD.Get_rank() != 0:
            return 0
    else:
        report = run.run(options.script, options.ranks, options.lmp, quiet=options.quiet)
    how = "stopped at" if report.stopped else "reached"
    print(f"{how} step {report.steps} after {report.wall_time:.1f} s")
    return 130 if report.stopped else 0


def _plot(options: argparse.Namespace) -> int:
    from peridem import render

    path = options.output or options.folder / "stress.png"
    print(f"written to {render.stress_png(options.folder, path, options.wall)}")
    return 0


def _render(options: argparse.Namespace) -> int:
    from peridem import render

    path = options.output or options.folder / "grains.png"
    written = render.grains_png(options.folder, path, options.frames, options.top)
    print(f"written to {written}")
    if options.pvd:
        print(f"written to {render.pvd(options.folder, options.folder / 'grains.pvd')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
