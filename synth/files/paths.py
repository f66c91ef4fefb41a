"""Files named in a user's file: they must lie in its folder's tree.

A leg file may be shared by several projects: it may also lie elsewhere in the project's repository, or
anywhere with ``allowing_outside``.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path, PurePosixPath, PureWindowsPath

from synth.cache import home_folder
from synth.errors import Problem, UserError, did_you_mean
from synth.files.names import unprinted

GLOB_LIMIT = 5_000  # files that one pattern may match
REPOSITORY = (".git", ".hg", ".svn")  # what a repository's root holds
_anywhere: ContextVar[bool] = ContextVar("shared files may lie anywhere", default=False)


@contextmanager
def allowing_outside() -> Iterator[None]:
    """Within the block, ``shared`` accepts files anywhere (``--allow-outside``)."""
    token = _anywhere.set(True)
    try:
        yield
    finally:
        _anywhere.reset(token)


def repository_root(folder: Path) -> Path | None:
    """The nearest repository folder at or above ``folder``; never the home folder or the root."""
    whole, home = Path(os.path.realpath(folder)), home_folder()
    for place in (whole, *whole.parents):
        if place in (home, Path(place.anchor)):
            return None
        if any((place / mark).exists() for mark in REPOSITORY):
            return place
    return None


def name_from(folder: Path, path: Path) -> str:
    """A file's name relative to a folder, with ``..`` where it lies outside."""
    try:
        return path.relative_to(folder).as_posix()
    except ValueError:
        return Path(os.path.relpath(os.path.realpath(path), os.path.realpath(folder))).as_posix()


def text_of(path: str | Path) -> str:
    """A path as text that any file can hold: bytes that are not UTF-8 as ``\\xff``."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def refuse_unreadable_name(path: str | Path) -> None:
    """Refuse a file whose name is not UTF-8 or contains control characters, because results list their input files.

    Raises
    ------
    UserError
    """
    shown = text_of(path)
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        raise UserError(Problem(f'the name "{shown}" is not UTF-8 text; rename the file', shown)) from None
    bad = unprinted(str(path))
    if bad is not None:
        raise UserError(
            Problem(f'"{shown}" cannot be a file name: it holds the character {bad}; rename the file', shown)
        )


def read_bytes(path: Path, limit: int, remedy: str, *, first: int | None = None) -> bytes:
    """Read a regular file of at most ``limit`` bytes, all of it or the ``first`` so many bytes.

    Raises
    ------
    UserError
        If it is missing, not a regular file (a pipe would block), too large, or cannot be read.
    """
    name = text_of(path)
    refuse_unreadable_name(path.name)
    try:
        size = size_of_regular(path, name)
        if size > limit:
            raise UserError(Problem(f"has {size / 1e6:.0f} MB; at most {limit / 1e6:g} MB: {remedy}", name))
        with path.open("rb") as stream:
            data = stream.read(limit + 1 if first is None else first)
    except FileNotFoundError:
        raise UserError(Problem(f"does not exist{_near_file(path)}", name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be read: {reason}", name)) from None
    if len(data) > limit:
        raise UserError(Problem(f"is larger than {limit / 1e6:g} MB: {remedy}", name))
    return data


def is_folder(name: str) -> bool:
    """Whether a folder has that name; a name too long to be one has none, where ``Path.is_dir`` raises."""
    return os.path.isdir(name)  # noqa: PTH112


def size_of_regular(path: Path, name: str) -> int:
    """Bytes of a regular file, asked before it is opened: opening a pipe would wait for a writer.

    Raises
    ------
    UserError : a folder, a pipe or a device. OSError as ``Path.stat``.
    """
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise UserError(Problem("is a folder; name the file in it", name))
    if not stat.S_ISREG(status.st_mode):
        raise UserError(Problem("is not a regular file", name))
    return status.st_size


def inside(folder: Path, name: str) -> Path:
    """The file ``name`` relative to ``folder``, which must lie in the folder's tree.

    Raises
    ------
    UserError
        For an absolute path, one that leaves the tree, or one that does not exist. The problem
        has no file or line, because only the caller knows them.
    """
    return _named(folder, name, folder, "files must lie inside the folder of the file naming them")


def refuse_outside(folder: Path, path: Path, name: str) -> None:
    """Refuse a ``path``, named ``name``, that is absolute or leaves the folder's tree, whether it exists or not.

    Raises
    ------
    UserError
        The problem has no file or line, because only the caller knows them.
    """
    _refuse_absolute(name)
    _refuse_outside(folder, path, name)


def shared(folder: Path, name: str) -> Path:
    """A file that several projects may share: ``inside`` of the repository that holds ``folder``, if one does.

    Raises
    ------
    UserError
        As ``inside``; within ``allowing_outside`` the file may lie anywhere.
    """
    if _anywhere.get():
        return _named(folder, name, None, "")
    root = repository_root(folder)
    where = "this folder, which is in no repository" if root is None else f"the repository {_shown(root)}"
    return _named(folder, name, root or folder, f"a leg must lie inside {where}; --allow-outside lets it lie anywhere")


def _named(folder: Path, name: str, root: Path | None, allowed: str) -> Path:
    """The file ``name`` relative to ``folder``, inside ``root`` where there is one."""
    _refuse_absolute(name)
    try:
        path = folder / name
        if root is not None:
            _refuse_outside(root, path, name, allowed)
        if path.is_dir():
            raise UserError(f'"{name}" is a folder; name a file')
        if not path.exists():
            raise UserError(f'"{name}" does not exist in {_shown(folder)}{_near_file(path)}')
    except (OSError, ValueError, RuntimeError) as error:  # RuntimeError: a link that leads to itself
        raise UserError(f"{name[:80]!r} cannot be used as a file name: {error}") from None
    return path


def matching(folder: Path, pattern: str) -> list[Path]:
    """The files that ``pattern`` (a name or a glob) stands for, sorted, all inside the folder's tree.

    Raises
    ------
    UserError
        As ``inside``, and where a glob matches no file.
    """
    if not any(sign in pattern for sign in "*?[") or _is_file(folder / pattern):
        return [inside(folder, pattern)]
    _refuse_absolute(pattern)
    if ".." in PurePosixPath(pattern).parts:
        raise UserError(f'"{pattern}" climbs out with ".."; files must lie inside the folder of the file naming them')
    found: list[Path] = []
    try:
        for path in _globbed(folder, pattern):
            name = path.relative_to(folder).as_posix()
            refuse_unreadable_name(name)
            if _is_meant(path, name, pattern):
                _refuse_outside(folder, path, name)
                found.append(path)
            if len(found) > GLOB_LIMIT:
                raise UserError(f'"{pattern}" matches more than {GLOB_LIMIT} files; narrow it')
    except (OSError, ValueError, RuntimeError) as error:
        raise UserError(f'"{pattern}" cannot be used as a pattern: {error}') from None
    if not found:
        raise UserError(f'"{pattern}" matches no file in {_shown(folder)}')
    return sorted(found)


def _globbed(folder: Path, pattern: str) -> Iterator[Path]:
    """The matches of a pattern, broken links included."""
    head, _, last = pattern.rpartition("/")
    if head and not any(sign in last for sign in "*?["):  # Path.glob skips such a link under a plain name
        yield from (place / last for place in folder.glob(head) if os.path.lexists(place / last))
    else:
        yield from folder.glob(pattern)


def _is_meant(path: Path, name: str, pattern: str) -> bool:
    """Whether a match is a file, False for a folder that ``trials/*`` finds among files.

    Raises
    ------
    UserError : the file is missing, or a folder has the extension of a file, which would silently drop a recording.
    """
    if not os.path.isdir(path):  # noqa: PTH112 (Path.is_dir raises on a link that leads to itself)
        if not os.path.exists(path):  # noqa: PTH110
            raise UserError(f'"{pattern}" matches "{name}", a link that leads nowhere; mend or remove it')
        return True
    if PurePosixPath(pattern).suffix:
        raise UserError(f'"{pattern}" matches "{name}", which is a folder; rename it, or name the files in it')
    return False


def _refuse_absolute(name: str) -> None:
    if not name.strip():
        raise UserError("a file name is needed here")
    bad = unprinted(name)
    if bad is not None:
        raise UserError(f"{name[:60]!a} cannot be a file name: it holds the character {bad}; rename the file")
    if PurePosixPath(name).is_absolute() or PureWindowsPath(name).drive or name.startswith(("~", "\\")):
        raise UserError(f'"{name}" is an absolute path; name the file relative to the folder of the file naming it')


def _refuse_outside(
    folder: Path, path: Path, name: str, allowed: str = "files must lie inside the folder of the file naming them"
) -> None:
    root = Path(os.path.realpath(folder))
    target = Path(os.path.realpath(path))
    if target != root and root not in target.parents:
        link = "" if ".." in PurePosixPath(name).parts else ", by a link"
        raise UserError(f'"{name}" leads out of {_shown(folder)}{link}; {allowed}')


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _near_file(path: Path) -> str:
    """A suggestion of an existing file with a similar name."""
    try:
        names = [entry.name for _, entry in zip(range(1000), path.parent.iterdir(), strict=False)]
    except OSError:
        return ""
    if path.name in names:
        return ": it is a link that leads nowhere"
    return did_you_mean(path.name, map(text_of, names))


def _shown(folder: Path) -> str:
    return "this folder" if str(folder) in ("", ".") else str(folder)
