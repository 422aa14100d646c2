"""Running an input script: under ``mpirun``, or in this process.

Both show how far the run is and how long it will take, stop cleanly on Ctrl-C or SIGTERM (the
script made by :mod:`peridem.scene` then writes its restart file), and report a failure with
LAMMPS's own message and the line of the script.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from peridem.scene import STOP

LOG = "log.lammps"
GRACE = 60.0  # seconds between the request to stop and the end by force


class RunError(RuntimeError):
    """LAMMPS could not be started or failed; the message says why and where."""


@dataclass(frozen=True)
class RunReport:
    """How a run went.

    Attributes:
        steps: the last step reached.
        wall_time: seconds it took.
        stopped: whether it was ended early on request.
    """

    steps: int
    wall_time: float
    stopped: bool


def find_lmp(lmp: str | Path | None = None) -> Path:
    """The ``lmp`` program: as given, ``$LAMMPS_LMP``, ``build/lmp`` of the source tree, or on the
    search path, in this order.

    Raises:
        RunError: none of these is there.
    """
    tree = Path(__file__).resolve().parents[2] / "build" / "lmp"
    asked = lmp or os.environ.get("LAMMPS_LMP")
    if asked:
        found = shutil.which(str(asked))
        if found is None:
            raise RunError(f"no program {asked}")
        return Path(found)
    if tree.is_file():
        return tree
    on_path = shutil.which("lmp")
    if on_path is None:
        raise RunError(
            "no lmp program: build it (make build), or say where it is with --lmp or LAMMPS_LMP"
        )
    return Path(on_path)


def find_script(path: str | Path) -> Path:
    """The input script itself, or the only ``in.*`` file of a folder.

    Raises:
        FileNotFoundError: there is none.
        ValueError: there are several.
    """
    path = Path(path)
    if path.is_file():
        return path
    scripts = sorted(path.glob("in.*")) if path.is_dir() else []
    if not scripts:
        raise FileNotFoundError(f"no input script at {path}")
    if len(scripts) > 1:
        raise ValueError(f"several input scripts in {path}: {', '.join(s.name for s in scripts)}")
    return scripts[0]


def run(
    script: str | Path,
    ranks: int = 1,
    lmp: str | Path | None = None,
    variables: dict[str, str] | None = None,
    quiet: bool = False,
) -> RunReport:
    """Run a script in its own folder with ``mpirun -np ranks lmp``.

    Args:
        script: the script, or its folder.
        ranks: MPI processes; more than there are processors are allowed, and slow.
        lmp: the program (see :func:`find_lmp`).
        variables: for ``-var``.
        quiet: no progress bar.

    Raises:
        RunError: LAMMPS failed, or is not there.
    """
    script = find_script(script).resolve()
    if ranks < 1:
        raise ValueError(f"ranks must be at least 1, not {ranks}")
    command = [str(find_lmp(lmp)), "-in", script.name, "-log", LOG, "-screen", "none"]
    for name, value in (variables or {}).items():
        command += ["-var", name, value]
    environment = dict(os.environ)
    environment.setdefault("OMP_NUM_THREADS", "1")
    if ranks > 1:
        mpirun = shutil.which("mpirun")
        if mpirun is None:
            raise RunError("no mpirun on the search path: install Open MPI, or run on one rank")
        command = [mpirun, "-np", str(ranks), *command]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # as in a container
            environment.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
            environment.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        if ranks > (os.cpu_count() or 1):
            environment.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
    # its own process group: Ctrl-C at the terminal reaches only this process, which passes it on
    folder = script.parent
    _clear(folder)
    with (folder / "screen.txt").open("w") as screen:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=screen,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            with _stop_requests() as requested:
                report = _watch(
                    lambda: process.poll() is not None, folder, requested, script, quiet, GRACE
                )
        except BaseException:
            _end(process)
            raise
    if process.returncode != 0:
        output = (folder / "screen.txt").read_text(errors="replace")
        log = folder / LOG
        written = log.read_text(errors="replace") if log.is_file() else ""
        raise RunError(failure(written + output, script))
    (folder / "screen.txt").unlink()
    return report


def run_in_process(
    script: str | Path, cmdargs: Sequence[str] = (), quiet: bool = False
) -> RunReport:
    """Run a script with the ``lammps`` module: in this process, or all ranks under ``mpirun``.

    LAMMPS runs in a thread, so that signals and the progress bar are served meanwhile; as with
    :func:`run`, files are looked for and written in the folder of the script. Under ``mpirun``,
    which ends its processes on Ctrl-C without waiting, stop a run with ``touch stop`` there.

    Raises:
        RunError: no ``lammps`` module, or LAMMPS failed.
    """
    try:
        from lammps import lammps
        from mpi4py import MPI
    except (ImportError, OSError) as error:
        raise RunError(f"the lammps module cannot be loaded: {error}") from error
    script = find_script(script).resolve()
    first = MPI.COMM_WORLD.Get_rank() == 0
    if first:
        _clear(script.parent)
    MPI.COMM_WORLD.Barrier()
    before = Path.cwd()
    os.chdir(script.parent)
    failed: list[Exception] = []

    def work() -> None:
        try:
            engine = lammps(cmdargs=["-log", LOG, "-screen", "none", *cmdargs])
            try:
                engine.file(script.name)
            finally:
                engine.close()
        except Exception as error:
            failed.append(error)

    try:
        thread = threading.Thread(target=work, name="lammps")
        thread.start()
        with _stop_requests() as requested:
            report = _watch(
                lambda: not thread.is_alive(), script.parent, requested, script, quiet or not first
            )
        thread.join()
    finally:
        os.chdir(before)
    if failed:
        raise RunError(failure(f"{failed[0]}", script)) from failed[0]
    return report


def failure(output: str, script: Path) -> str:
    """LAMMPS's error message from its output, with the line of the script where it happened."""
    error = re.search(r"^ERROR( on proc \d+)?: ", output, re.MULTILINE)
    start = error.start() if error else 0
    lines = output[start:].splitlines()
    if error is None:  # it crashed, or was killed
        crash = re.search(r"exited on (signal \d+ \(.*?\))", output)
        lines = [f"ended by {crash[1]}, after" if crash else "ended without a message, after"]
        lines += output.split("\n---")[0].splitlines()[-5:]
    shown: list[str] = []
    for line in lines:
        if line.startswith(("---", "MPI_ABORT", "Primary job")):
            break
        shown.append(line.rstrip())
    where = re.search(r"Last (?:input line|command): *(.*)", output[start:])
    if where and (number := _line_number(script, where[1])):
        shown.append(f"at line {number} of {script}")
    else:
        shown.append(f"in {script}")
    text = "\n".join(line for line in shown[:20] if line)
    if "nknown atom style 'peridem'" in text or "nrecognized atom style 'peridem'" in text:
        text += "\nthis lmp was built without the PERIDEM package"
    return f"LAMMPS failed: {text}"


def _line_number(script: Path, command: str) -> int | None:
    wanted = command.split("#")[0].split()
    for number, line in enumerate(script.read_text().splitlines(), 1):
        if wanted and line.split("#")[0].split() == wanted:
            return number
    return None


def total_steps(script: str | Path) -> int:
    """Steps of all ``run`` commands with plain numbers in a script."""
    counts = re.findall(r"^\s*run\s+(\d+)\b", Path(script).read_text(), re.MULTILINE)
    return sum(int(count) for count in counts)


# ---- progress and stopping -----------------------------------------------------------------------


def _clear(folder: Path) -> None:
    for name in (STOP, LOG):
        (folder / name).unlink(missing_ok=True)


@contextmanager
def _stop_requests() -> Iterator[Callable[[], bool]]:
    """Turns SIGINT and SIGTERM into an answer to 'was a stop requested?'."""
    requests: list[int] = []

    def note(number: int, _frame: FrameType | None) -> None:
        requests.append(number)

    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(kind, note) for kind in kinds]
    try:
        yield lambda: bool(requests)
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def _watch(
    finished: Callable[[], bool],
    folder: Path,
    requested: Callable[[], bool],
    script: Path,
    quiet: bool,
    grace: float = math.inf,
) -> RunReport:
    """Follow the log until the run is over; pass a request to stop on through the stop file."""
    log, total = _LogFollower(folder / LOG), total_steps(script)
    begin = time.monotonic()
    asked_at: float | None = None
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("step {task.completed:,.0f} of {task.total:,.0f}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    console = Console(file=sys.stderr)
    with Progress(*columns, console=console, disable=quiet, refresh_per_second=4) as progress:
        task = progress.add_task("running", total=max(total, 1))
        while not finished():
            progress.update(task, completed=log.step())
            if requested() and asked_at is None:
                asked_at = time.monotonic()
                (folder / STOP).touch()
                progress.update(task, description="stopping")
            if asked_at is not None and time.monotonic() - asked_at > grace:
                raise RunError(f"LAMMPS did not stop within {grace:g} s and was ended")
            time.sleep(0.1)
        progress.update(task, completed=log.step())
    stopped = asked_at is not None or (folder / STOP).exists()  # or by hand
    (folder / STOP).unlink(missing_ok=True)
    return RunReport(log.step(), time.monotonic() - begin, stopped)


class _LogFollower:
    """Reads the step from the thermo lines of a log file as it grows."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._offset = 0
        self._rest = ""
        self._step = 0
        self._inside = False

    def step(self) -> int:
        if not self._path.is_file():
            return self._step
        with self._path.open(errors="replace") as file:
            file.seek(self._offset)
            text = self._rest + file.read()
            self._offset = file.tell()
        *lines, self._rest = text.split("\n")
        for line in lines:
            words = line.split()
            if words[:1] == ["Step"]:
                self._inside = True
            elif line.startswith("Loop time"):
                self._inside = False
            elif self._inside and words and words[0].isdigit():
                self._step = max(self._step, int(words[0]))
        return self._step


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the program and what it started."""
    if process.poll() is not None:
        return
    for number in (signal.SIGTERM, signal.SIGKILL):
        os.killpg(process.pid, number)
        try:
            process.wait(10.0)
            return
        except subprocess.TimeoutExpired:
            continue
