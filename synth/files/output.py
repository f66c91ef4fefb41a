"""Write results: a folder complete or not at all, with the same bytes on every run."""

from __future__ import annotations

import csv
import errno
import os
import tempfile
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.leftovers import PARTIAL, REPLACED, held_folder, one_at_a_time, put_back, remove_leftovers, remove_tree
from synth.files.names import written_name
from synth.files.run_manifest import MANIFEST, refuse_unless_replaceable, write_manifest
from synth.files.signals import signals_held_back, terminated_as_exception
from synth.files.text_forms import cells, clock_cells, defused, json_text, plain
from synth.threads import waited_for

# Temporary folders of the active runs of this thread, innermost last: two threads may write two results at once.
_written: ContextVar[tuple[Path, ...]] = ContextVar("temporary folders of active runs", default=())
_asking = threading.Lock()
# Files that wait for the disk at once: it then takes them into its journal together. The 337 of the built-in example's
# leg take 0.08 s; one after the other 0.9 s, four at once 0.11 s, sixteen 0.07 s.
FLUSHED_AT_ONCE = 8
_USER_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG})


@contextmanager
def output_folder(
    path: str | Path, *, overwrite: bool = True, inputs: Sequence[Path] = (), contents: Collection[str] = ()
) -> Iterator[Path]:
    """A temporary folder that is renamed to ``path`` when the block succeeds and deleted when it fails.

    Parameters
    ----------
    path
        the result folder. If it exists it must be empty or contain only files of an earlier run, which nobody
        changed, and which are then replaced; missing parents are created.
    overwrite
        False: refuse to replace an earlier run.
    inputs
        files that this run reads: a folder that holds one of them is not replaced.
    contents
        SHA-256 of files that were read from places that are not known: the same holds for them.

    Yields
    ------
    The temporary folder, beside the target, so that the final rename is one step.

    Raises
    ------
    UserError
        If the target has no name, holds anything else, is a file or the current folder, or its parent cannot be
        written.
    """
    name = str(path)
    if not name.strip():  # the real path of that would be the current folder
        raise UserError("the name of the folder to write is empty; name a folder to make")
    target = Path(os.path.realpath(path))
    made: list[Path] = []
    try:
        with disk_errors_as(name):
            if target.is_symlink():  # what the real path still has is a link that leads back to itself
                raise UserError(Problem("is a link that leads to itself; name another folder", name))
            put_back(target)
            _check_target(target, name, inputs, contents, overwrite=overwrite)
            made = _make_parents(target.parent)
            temporary, lock = own_place(target, name)
    except BaseException:
        _remove_empty(made)
        raise
    finished = False
    token = _written.set((*_written.get(), temporary))
    try:
        with terminated_as_exception(), disk_errors_as(name, temporary):
            yield temporary
            with disk_errors_as(name):
                _complete(temporary)
                # It may have changed meanwhile: the run was long.
                _check_target(target, name, inputs, contents, overwrite=overwrite)
                _move(temporary, target)
            finished = True
    finally:
        _written.reset(token)
        if not finished:
            remove_tree(temporary)
            _remove_empty(made)
        if lock is not None:
            os.close(lock)


@contextmanager
def disk_errors_as(name: str, folder: Path | None = None) -> Iterator[None]:
    """Report disk errors as the user's, under the result's name.

    With a ``folder`` that a run is filling, only a full or read-only disk is the user's concern, and a file elsewhere
    is reported under its own name; any other error there is an internal one.
    """
    try:
        yield
    except OSError as error:
        if folder is not None and error.errno not in _USER_ERRORS:
            raise
        elsewhere = folder is not None and error.filename is not None and str(folder) not in str(error.filename)
        place = str(error.filename) if elsewhere else name
        raise UserError(Problem(f"cannot be written: {error.strerror or error}", place)) from None


def own_place(target: Path, name: str) -> tuple[Path, int | None]:
    """A temporary folder beside the target, locked by this process; leftovers of killed runs are removed.

    Raises
    ------
    UserError : another process is writing the same result.
    """
    with one_at_a_time(target.parent):
        living = remove_leftovers(target.parent, PARTIAL.format(target.name))
        living += remove_leftovers(target.parent, REPLACED.format(target.name))
        if living:
            raise UserError(Problem("is being written by another run; wait for it, or name another folder", name))
        return held_folder(target.parent, PARTIAL.format(target.name))


def place(folder: Path, name: str) -> Path:
    """The new file ``name`` in ``folder``.

    Raises
    ------
    UserError : the path leads out of the folder, or the file exists already.
    """
    path = folder / name
    _require_inside(path, folder)
    if os.path.lexists(path):
        raise UserError(Problem("would be written twice: two names of the project give the same file name", name))
    return path


def write_text(path: Path, text: str) -> None:
    """Write a text of the result in UTF-8.

    Raises
    ------
    UserError : while a run writes its folder, the path leads out of it.
    """
    _require_within_run(path)
    path.write_text(text, encoding="utf-8", newline="\n")


def write_bytes_whole(path: Path, data: bytes, mode: int | None = None) -> None:
    """Write a file beside a result, complete or, after any error or kill, not at all.

    ``mode``: its permissions, default only the user's.
    """
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".partial")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(handle)
        if mode is not None:
            Path(temporary).chmod(mode)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def write_json(path: Path, value: Any) -> None:
    """Write JSON with 10 significant digits, keys in the order given, and a newline at the end.

    Raises
    ------
    ValueError
        For a number that is not finite, with the path of its key: JSON has no such number.
    TypeError
        For a value that is no mapping, sequence, array, number, text, bool or None.
    UserError
        As ``write_text``.
    """
    write_text(path, json_text(plain(value, ""), 0) + "\n")


def write_csv(path: Path, columns: Mapping[str, Sequence[Any] | np.ndarray[Any, Any]]) -> None:
    """Write columns of equal length under their headers; numbers to 10 digits, nan and None as empty cells.

    A column ``time`` is written to 1e-9 of its unit where ten digits are coarser.

    Raises
    ------
    ValueError
        If the columns differ in length or a number is infinite.
    UserError
        As ``write_text``.
    """
    _require_within_run(path)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([defused(title) for title in columns])
        texts = (clock_cells(column) if _is_clock(title) else cells(column) for title, column in columns.items())
        writer.writerows(zip(*texts, strict=True))


def _is_clock(title: str) -> bool:
    """Whether a column contains times."""
    return title.partition("[")[0].strip() == "time"


def stems(names: Sequence[str]) -> list[str]:
    """A unique file name for each trial, without folders, in characters that every system accepts."""
    found: list[str] = []
    for name in names:
        stem = written_name(Path(name).stem)
        if stem in found:
            stem = written_name(name.replace("/", "__").removesuffix(".csv"))
        while stem in found:
            stem += "_"
        found.append(stem)
    return found


def _require_inside(path: Path, folder: Path) -> None:
    """Refuse a path that, with links resolved, is not below the folder."""
    if Path(os.path.realpath(folder)) not in Path(os.path.realpath(path)).parents:
        raise UserError(Problem("leads out of the folder that is written; nothing is written there", str(path)))


def _require_within_run(path: Path) -> None:
    """Refuse to write elsewhere while a run of this thread writes its folder."""
    if folders := _written.get():
        _require_inside(path, folders[-1])


def _check_target(
    target: Path, name: str, inputs: Sequence[Path], contents: Collection[str], *, overwrite: bool
) -> None:
    """Refuse to replace anything but an empty folder or an unchanged earlier run that is no input of this one."""
    if target == Path.cwd() or target in Path.cwd().parents:
        raise UserError(Problem("is the current folder or lies above it; name a folder to make", name))
    try:
        if not target.exists():
            return
        if not target.is_dir():
            raise UserError(Problem("is a file; name a folder", name))
        if os.path.ismount(target):  # it cannot be replaced by another folder, and that would show only after the work
            raise UserError(Problem(f"is where a disk is mounted; name a folder in it, such as {name}/result", name))
        if not os.access(target, os.W_OK | os.X_OK):
            raise UserError(Problem("may not be written (chmod u+w); name another folder or allow it", name))
        refuse_unless_replaceable(target, name, inputs, contents, overwrite=overwrite)
    except OSError as error:
        raise UserError(Problem(f"cannot be read: {error.strerror}", name)) from None


def _complete(folder: Path) -> None:
    """Add the manifest and the usual permissions of the user's folders (mkdtemp gives 0700); flush to disk."""
    entries = sorted(folder.rglob("*"))
    if any(entry.is_symlink() for entry in entries):
        raise ValueError(f"a link stands in the result: {[str(entry) for entry in entries if entry.is_symlink()]}")
    files = [entry.relative_to(folder).as_posix() for entry in entries if not entry.is_dir()]
    write_manifest(folder, files)
    folder.chmod(0o777 & ~umask())
    waited_for(_flush, (folder / MANIFEST, *entries, folder), FLUSHED_AT_ONCE)


def umask() -> int:
    """The permissions that new files of the user do not get; it can only be read by setting it."""
    with _asking:  # a second thread between the two would read 0 and leave it so
        mask = os.umask(0)
        os.umask(mask)
    return mask


def _flush(path: Path) -> None:
    """Flush a file, or a folder's list of files, to disk: otherwise a rename may arrive before its content."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF):  # a file system without it
            raise
    finally:
        os.close(handle)


def _move(temporary: Path, target: Path) -> None:
    """Replace the target by the finished folder; if that fails, restore the target."""
    if not target.exists():
        temporary.rename(target)
        _flush(target.parent)
        return
    aside, lock = held_folder(target.parent, REPLACED.format(target.name))
    old = aside / "old"
    try:
        with signals_held_back():
            target.rename(old)
            try:
                temporary.rename(target)
            except BaseException:
                old.rename(target)
                raise
        _flush(target.parent)
    finally:
        if os.path.lexists(target):  # else the earlier result is still aside: the next run puts it back
            remove_tree(aside)
        if lock is not None:
            os.close(lock)


def _make_parents(folder: Path) -> list[Path]:
    """Make missing folders; returns those made, innermost first."""
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    standing = missing[-1].parent if missing else folder
    if not standing.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, f"{standing} is a file")
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def _remove_empty(folders: Sequence[Path]) -> None:
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()
