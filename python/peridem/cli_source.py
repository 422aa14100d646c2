"""What the command line can run: input scripts, folders, scenes in Python, PeriDEM decks."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from pathlib import Path

from peridem.run import find_script
from peridem.scene import Scene

MAKER = "make_scene"


def is_source(path: Path) -> bool:
    """Whether a path names a scene or a deck, from which a script must be made first."""
    return path.suffix in (".py", ".yaml", ".yml")


def folder_of(path: Path, output: Path | None) -> Path:
    """Where the script of a scene or deck goes: as given, or out/NAME."""
    return output or Path("out") / path.stem


def script_of(
    path: Path,
    output: Path | None,
    as_published: bool,
    keep: bool = False,
    after: Path | None = None,
) -> tuple[Path, list[str]]:
    """The input script of whatever is given, and what is to be said about it.

    Args:
        path: a script, a folder with one, a scene (.py) or a deck (.yaml).
        output: folder for what is made of a scene or deck.
        as_published: read a deck as PeriDEM computes it.
        keep: use the script that is in the folder already.
        after: folder of the run that a scene or deck goes on from.

    Raises:
        FileNotFoundError, ValueError: there is none, or it cannot be read.
    """
    if not is_source(path):
        if as_published:
            raise ValueError(f"{path}: only a deck (.yaml) can be read as published")
        if output is not None:
            raise ValueError(f"{path}: a script runs in its own folder, -o is for scenes and decks")
        if after is not None:
            raise ValueError(
                f"{path}: a script says itself what it begins with, --after is for scenes and decks"
            )
        return find_script(path), []
    folder = folder_of(path, output)
    if keep:
        return find_script(folder), []
    return convert(path, folder, as_published, after)


def convert(
    path: Path, folder: Path, as_published: bool = False, after: Path | None = None
) -> tuple[Path, list[str]]:
    """Write the input script and data file of a scene or deck into a folder.

    Args:
        path: a scene (.py) or a deck (.yaml).
        folder: to write to.
        as_published: read a deck as PeriDEM computes it.
        after: folder of the run that it goes on from.

    Returns:
        The path of the script, and the report on a deck, line by line.
    """
    if path.is_dir():
        raise ValueError(f"{path.resolve()} is a folder; a scene (.py) or a deck (.yaml) needed")
    if not path.is_file():
        raise FileNotFoundError(f"no file {path}")
    if after is not None and after.resolve() == folder.resolve():
        raise ValueError(f"{folder} holds the run to go on from: say another folder with -o")
    report: list[str] = []
    if path.suffix == ".py":
        if as_published:
            raise ValueError(f"{path}: only a deck (.yaml) can be read as published")
        scene = load_scene(path)
        scene = scene if after is None else scene.after(after)
    elif is_source(path):
        from peridem import deck

        read = deck.load(path, as_published=as_published, after=after)
        scene, report = read.scene, list(read.report)
    else:
        raise ValueError(f"{path}: a scene (.py) or a deck (.yaml) needed")
    return scene.write(folder), report


def load_scene(path: Path) -> Scene:
    """The scene that a Python file makes: what its ``make_scene()`` returns, or its only Scene.

    Raises:
        ValueError: the file fails, or holds no scene; with the line where it failed.
    """
    spec = importlib.util.spec_from_file_location(f"scene_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.resolve().parent))  # it may import its neighbours
    sys.modules[spec.name] = module  # as dataclasses need
    try:
        spec.loader.exec_module(module)
        maker = getattr(module, MAKER, None)
        if callable(maker):
            made = maker()
            if not isinstance(made, Scene):
                raise TypeError(f"{MAKER}() returned {type(made).__name__}, not a Scene")
            return made
    except Exception as error:
        what = error.msg if isinstance(error, SyntaxError) else error
        raise ValueError(f"{path}{_line(error, path)}: {what}") from error
    finally:
        sys.path.remove(str(path.resolve().parent))
        del sys.modules[spec.name]
    scenes = [value for value in vars(module).values() if isinstance(value, Scene)]
    if len(scenes) != 1:
        raise ValueError(
            f"{path}: a function {MAKER}() that needs no arguments, or one Scene, needed; "
            f"it has {len(scenes)} scenes"
        )
    return scenes[0]


def _line(error: Exception, path: Path) -> str:
    """', line N' where a file failed."""
    if isinstance(error, SyntaxError):
        return f", line {error.lineno}"
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).resolve() == path.resolve()
    ]
    return f", line {frames[-1].lineno}" if frames else ""
