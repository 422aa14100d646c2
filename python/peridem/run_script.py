"""The input script as :mod:`peridem.run` lets LAMMPS read it.

LAMMPS gets a copy of the script with a few more commands, all of their names beginning with
``peridem_``. The script itself stays as it is.

- Every ``run`` ends early when a file named ``stop`` appears; then a restart file is written and
  the rest of the script is passed over.
- After each ``run`` a line of a journal tells at which step it ended.
- On request every ``run`` is cut in pieces, with a restart file after each.
- To go on from a restart file, ``read_restart`` takes the place of ``read_data`` or ``create_box``;
  runs that had ended, and commands before the point of the restart that change nodes, are passed
  over; output is appended.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from peridem.run_restart import restart_units

LOG, STOP = "log.lammps", "stop"
CHECK = 20  # steps between two looks for the stop file
END = "peridem_end"

CREATE = ("read_data", "create_box", "read_restart")
# what changes nodes or writes files once: not again before the point where a run goes on
ONCE = (
    *CREATE,
    "change_box",
    "create_atoms",
    "delete_atoms",
    "displace_atoms",
    "group",
    "minimize",
    "print",
    "replicate",
    "reset_atoms",
    "set",
    "shell",
    "velocity",
    "write_data",
    "write_dump",
    "write_restart",
)
NOT_RESUMED = ("clear", "reset_timestep", "rerun", "neb", "prd", "tad", "temper", "hyper")


@dataclass(frozen=True)
class Command:
    """One command of a script: its text as written, its words, the number of its first line."""

    text: str
    words: tuple[str, ...]
    line: int

    @property
    def name(self) -> str:
        """The first word."""
        return self.words[0] if self.words else ""


@dataclass(frozen=True)
class Resume:
    """Where a run goes on.

    Attributes:
        restart: the restart file, as seen from the folder of the script.
        done: how many ``run`` commands had ended.
        start: step at which the next one had begun.
        step: of the restart file.
    """

    restart: str
    done: int
    start: int
    step: int


@dataclass(frozen=True)
class Prepared:
    """A script ready for LAMMPS: its text, and for each of its lines that of the original."""

    text: str
    origin: tuple[int, ...]


def commands(text: str) -> list[Command]:
    """The commands of a script; a line that ends with ``&`` goes on in the next."""
    found: list[Command] = []
    pending: list[str] = []
    first = 1
    quoted = False
    for number, line in enumerate(text.splitlines(), 1):
        if not pending:
            first = number
        pending.append(line)
        quoted ^= line.count('"""') % 2 == 1
        if quoted or _bare(line).rstrip().endswith("&"):
            continue
        joined = " ".join(re.sub(r"&\s*$", "", _bare(piece).rstrip()) for piece in pending)
        found.append(Command("\n".join(pending), tuple(joined.split()), first))
        pending = []
    if pending:
        found.append(Command("\n".join(pending), tuple(" ".join(pending).split()), first))
    return found


def _bare(line: str) -> str:
    """A line without its comment; a # between quotes starts none."""
    inside = ""
    for at, letter in enumerate(line):
        if letter == "#" and not inside:
            return line[:at]
        if letter in "\"'" and inside in ("", letter):
            inside = "" if inside else letter
    return line


def total_steps(text: str, folder: Path | None = None) -> int | None:
    """Steps of all ``run`` commands; None if they cannot be known (variables, loops)."""
    total = 0
    for command in _inlined(commands(text), folder):
        if command.name in ("jump", "if") and re.search(r"\b(jump|run)\b", command.text):
            return None
        if command.name == "run":
            if len(command.words) < 2 or not command.words[1].isdigit():
                return None
            upto = "upto" in command.words[2:]
            total = int(command.words[1]) + (0 if upto else total)
    return total


def end_time(text: str) -> float | None:
    """The time that ends the run, where a variable says ``time>=...`` (with ``fix halt``)."""
    said = re.search(r"^\s*variable\s+(\S+)\s+equal\s+time>=([-+.\deE]+)\s*$", text, re.MULTILINE)
    if said and re.search(rf"^\s*fix\s.*\shalt\s.*\bv_{said[1]}\b", text, re.MULTILINE):
        return float(said[2])
    return None


@dataclass(frozen=True)
class Outputs:
    """Files that a script adds to as it runs, as far as it names them plainly.

    Attributes:
        dumps: of ``dump``.
        tables: of fixes that write a line now and then.
        repeated: those of the tables that get a line at the very step where a run begins.
    """

    dumps: tuple[Path, ...]
    tables: tuple[Path, ...]
    repeated: frozenset[Path]


def output_files(text: str, folder: Path) -> Outputs:
    """The files that a script in a folder writes."""
    dumps, tables, repeated = [], [], set()
    for command in _inlined(commands(text), folder):
        words, at = command.words, _table_word(command.words)
        if command.name == "dump" and len(words) > 5 and not re.search(r"[$*%]", words[5]):
            dumps.append(folder / words[5])
        elif at is not None and "$" not in words[at + 1]:
            tables.append(folder / words[at + 1])
            if words[3].startswith("ave/") and words[5] == "1":  # no average, nothing to wait for
                repeated.add(tables[-1])
    return Outputs(tuple(dumps), tuple(tables), frozenset(repeated))


def broken_bonds(text: str) -> str | None:
    """What the number of broken bonds is called in the script; None if it has no bonds."""
    made = re.search(r"^\s*fix\s+(\S+)\s+\S+\s+peridem/bonds\b", text, re.MULTILINE)
    if made:
        return f"f_{made[1]}[2]"
    return "f_peridem_bonds[2]" if re.search(r"\bperidem/(lps|pmb)\b", text) else None


def drift_columns(text: str) -> tuple[str, ...]:
    """Thermo columns with the drift of the energy balance (``compute peridem/energy``)."""
    made = re.search(r"^\s*compute\s+(\S+)\s+\S+\s+peridem/energy\b", text, re.MULTILINE)
    return (f"c_{made[1]}[8]", f"c_{made[1]}") if made else ()


def units(text: str, folder: Path) -> str:
    """The system of units of a script, also where a restart file says it; '' if none is known."""
    found = "lj"  # as LAMMPS begins
    for command in _inlined(commands(text), folder):
        if command.name == "units" and len(command.words) > 1:
            found = command.words[1]
        elif command.name == "read_restart" and len(command.words) > 1:
            try:
                found = restart_units(folder / command.words[1])
            except (OSError, ValueError, struct.error):  # not there yet, or a * in its name
                found = ""
    return found


def prepare(
    text: str,
    name: str,
    *,
    folder: Path | None = None,
    report: int = 100,
    checkpoint: int | None = None,
    resume: Resume | None = None,
) -> Prepared:
    """The copy of a script that LAMMPS gets.

    Args:
        text: the script.
        name: of its restart file and journal: NAME.restart, NAME.journal.
        folder: where its ``include`` files are.
        report: steps between two reports of progress.
        checkpoint: steps between restart files; None: only when stopped.
        resume: where it goes on; None: from its start.

    Raises:
        ValueError: it holds a command with which it cannot go on.
    """
    writer = _Writer(text, name, report, checkpoint, resume)
    for command in _inlined(commands(text), folder):
        writer.add(command)
    return writer.finish()


def _inlined(found: list[Command], folder: Path | None) -> Iterator[Command]:
    """Commands with those of ``include`` files in place, if these are named plainly."""
    for command in found:
        path = folder / command.words[1] if folder and len(command.words) > 1 else None
        if command.name == "include" and path is not None and path.is_file():
            inner = _inlined(commands(path.read_text()), folder)
            yield from (Command(c.text, c.words, command.line) for c in inner)
        else:
            yield command


def _table_word(words: tuple[str, ...]) -> int | None:
    """Where the keyword ``file`` of a fix that writes a table stands."""
    tables = ("ave/time", "ave/chunk", "print")
    if len(words) < 5 or words[0] != "fix" or words[3] not in tables or "overwrite" in words:
        return None
    for at in range(4, len(words) - 1):
        if words[at] in ("file", "append"):
            return at
    return None


class _Writer:
    """Builds the copy, command by command."""

    def __init__(
        self, text: str, name: str, report: int, checkpoint: int | None, resume: Resume | None
    ) -> None:
        self._name, self._report = name, report
        self._checkpoint, self._resume = checkpoint, resume
        self._broken = broken_bonds(text)
        self._created = False
        self._label = 0
        self._lines: list[str] = []
        self._origin: list[int] = []
        if resume:
            self._put(0, f"log {LOG} append", f"print '# goes on from step {resume.step}'")
        self._put(0, "variable peridem_run equal 0", f"variable peridem_stop equal is_file({STOP})")

    def finish(self) -> Prepared:
        last = self._origin[-1]
        self._put(last, f'print "complete" append {self._name}.journal screen no')
        self._put(last, f"label {END}")
        return Prepared("\n".join(self._lines) + "\n", tuple(self._origin))

    def add(self, command: Command) -> None:
        name = command.name
        if self._resume and name in NOT_RESUMED:
            raise ValueError(
                f"a script with '{name}' (line {command.line}) cannot go on from a restart file"
            )
        if name == "run" and len(command.words) > 1:
            self._run(command)
        elif name == "restart" and self._checkpoint:
            self._put(command.line, f"# {command.words[0]}: see the checkpoints")
        elif self._resume is None:
            self._keep(command)
        elif name in CREATE and not self._created:
            self._created = True
            self._put(command.line, f"read_restart {self._resume.restart}")
        elif name in ONCE and not (name == "group" and "dynamic" in command.words):
            label = self._skip(command.line)
            self._keep(command)
            self._put(command.line, f"label {label}")
        else:
            self._output(command, self._resume)

    def _put(self, origin: int, *lines: str) -> None:
        self._lines += lines
        self._origin += [origin] * len(lines)

    def _keep(self, command: Command) -> None:
        for at, line in enumerate(command.text.splitlines() or [""]):
            self._put(command.line + at, line)

    def _skip(self, line: int) -> str:
        """Jump over what follows unless it comes after the runs that had ended; to which label."""
        done = self._resume.done if self._resume else 0
        self._label += 1
        label = f"peridem_skip_{self._label}"
        self._put(line, f'if "${{peridem_run}} <= {done}" then "jump SELF {label}"')
        return label

    def _output(self, command: Command, resume: Resume) -> None:
        """A command that goes on writing what is there already."""
        words = list(command.words)
        at = _table_word(command.words)
        if command.name == "dump" and len(words) > 5:
            if words[5].endswith((".bin", ".gz")) and "*" not in words[5]:
                words[5] = part_name(words[5])  # LAMMPS appends to text only
                self._put(command.line, " ".join(words))
            else:
                self._keep(command)
                if "*" not in words[5]:
                    self._put(command.line, f"dump_modify {words[1]} append yes")
        elif at is not None:
            words[at] = "append"
            self._put(command.line, _requoted(command, words))
        elif command.name == "log" and len(words) == 2:
            self._put(command.line, f"log {words[1]} append")
        else:
            self._keep(command)

    def _run(self, command: Command) -> None:
        line, (_, length, *options) = command.line, command.words
        self._put(line, "variable peridem_run equal $(v_peridem_run+1)")
        self._put(line, "variable peridem_begin equal $(step)")
        label = ""
        if self._resume:
            label = self._skip(line)
            # the run that was cut off began where the one before it had ended
            first = f'"${{peridem_run}} == {self._resume.done + 1}"'
            begin = f'"variable peridem_begin equal {self._resume.start}"'
            self._put(line, f"if {first} then {begin}")
        end = length if "upto" in options else f"v_peridem_begin+{length}"
        self._put(line, f"variable peridem_to equal {end}", *self._watchers())
        note = "began $(v_peridem_run:%.0f) $(v_peridem_begin:%.0f)"
        self._put(line, f'print "{note}" append {self._name}.journal screen no')
        options = [word for word in options if word != "upto"]
        for word, value in (("start", "v_peridem_begin"), ("stop", "v_peridem_to")):
            if word not in options:  # what changes over a run does so over the whole of it
                options += [word, f"$({value}:%.0f)"]
        self._piece(line, " ".join(options))
        self._put(line, "unfix peridem_stop", "unfix peridem_report")
        note = "ended $(v_peridem_run:%.0f) $(step)"
        self._put(line, f'print "{note}" append {self._name}.journal screen no')
        if label:
            self._put(line, f"label {label}")

    def _piece(self, line: int, options: str) -> None:
        """The run itself, or the loop over its pieces.

        Whether it was stopped follows from the step, which is the same on all ranks: they cannot
        disagree about a stop file that appears just when a run ends by itself.
        """
        self._label += 1
        again = f"peridem_piece_{self._label}"
        wanted = "v_peridem_to"
        if self._checkpoint:
            self._put(line, f"label {again}")
            left = f"(v_peridem_to-step)>{self._checkpoint}"
            wanted = f"({left})*(step+{self._checkpoint})+(1-({left}))*v_peridem_to"
        self._put(line, f"variable peridem_next equal $({wanted}:%.0f)")
        self._put(line, f"run ${{peridem_next}} upto {options}")
        self._put(line, "variable peridem_cut equal $(step<v_peridem_next&&v_peridem_stop>0)")
        write = " ".join(
            f'"{command}"'
            for command in (
                f"write_restart {self._name}.restart.part",
                f"shell mv {self._name}.restart.part {self._name}.restart",
            )
        )
        keep = "" if self._checkpoint else f"{write} "
        self._put(line, f'if "${{peridem_cut}} > 0" then {keep}"jump SELF {END}"')
        if self._checkpoint:
            more = '"$(step) == ${peridem_next} && $(step) < $(v_peridem_to:%.0f)"'
            self._put(line, f'if {more} then {write} "jump SELF {again}"')

    def _watchers(self) -> list[str]:
        shown = "$(step) $(time:%.9g)" + (f" $({self._broken}:%.0f)" if self._broken else "")
        return [
            f"fix peridem_stop all halt {CHECK} v_peridem_stop > 0 error continue message no",
            f'fix peridem_report all print {self._report} "{shown}" file {self._name}.progress '
            "screen no title ''",
        ]


def part_name(name: str) -> str:
    """Where a dump that LAMMPS cannot append to goes when a run goes on."""
    path = Path(name)
    return str(path.with_name(f"more-{path.name}"))


def _requoted(command: Command, words: list[str]) -> str:
    """A fix print holds quoted text: only its keyword changes."""
    if '"' in command.text or "'" in command.text:
        return re.sub(r"\bfile(\s+\S+)", r"append\1", command.text.replace("&\n", " "), count=1)
    return " ".join(words)
