"""Foreign formats: one decorated loader and one content validator each, discovered automatically.

A module of this package that decorates its loader with ``loader`` is a format; there is no other list. The format of a
file is determined from its content, never from its extension: every validator examines it.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.paths import size_of_regular
from synth.motion.importers.foreign_data import Source

START = 200_000  # bytes of a file that validators receive
UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # byte order marks
HDF5 = b"\x89HDF\r\n\x1a\n"
HDF5_EXTRAS = ("hdf5", "sleap")  # that read HDF5
SCANNED = 20_000_000  # bytes at either end of an HDF5 file; names stand where a writer began or last added
Reader = Callable[[Path, Mapping, str], Source]
Holds = Callable[[bytes, Path], bool]  # the file's first bytes, and the path for validators that need more


@dataclass(frozen=True)
class ForeignFormat:
    """A format.

    ``holds`` : whether a file is of it. ``gives`` : channels or points. ``space`` : its points may be
    in space, so ``plane`` applies. ``keys`` : further keys of a project that apply to it.
    ``package`` : its reader, None if none is needed; ``extra`` : the extra of this program that installs it.
    ``own_clock`` : the file has a clock, and none may be given. ``last`` : used only if no other matches, since
    almost any text would; of two such, that which gives what is asked for.
    """

    name: str
    title: str
    read: Reader
    holds: Holds
    gives: Literal["channels", "points"]
    space: bool = False
    keys: frozenset[str] = frozenset()
    package: str | None = None
    extra: str | None = None
    last: bool = False
    own_clock: bool = False

    @property
    def installed(self) -> bool:
        """Whether its package is installed."""
        return self.package is None or find_spec(self.package) is not None

    def require(self, name: str) -> None:
        """Raise UserError if its package is missing."""
        if not self.installed:
            text = f"is {self.title}, which {self.package} reads: pip install limb-synth[{self.extra}]"
            raise UserError(Problem(text, name))


_formats: dict[str, ForeignFormat] = {}


def loader(
    name: str,
    title: str,
    holds: Holds,
    gives: Literal["channels", "points"],
    *,
    space: bool = False,
    keys: frozenset[str] = frozenset(),
    needs: tuple[str, str] | None = None,
    last: bool = False,
    own_clock: bool = False,
) -> Callable[[Reader], Reader]:
    """Register the decorated function as the loader of a format; ``needs`` : package and extra."""
    package, extra = needs or (None, None)

    def register(read: Reader) -> Reader:
        _formats[name] = ForeignFormat(name, title, read, holds, gives, space, keys, package, extra, last, own_clock)
        return read

    return register


@cache
def formats() -> dict[str, ForeignFormat]:
    """Every format by name, in alphabetical order."""
    package = importlib.import_module("synth.motion.importers")
    for module in pkgutil.iter_modules(package.__path__):
        if module.name.startswith("from_") or module.name in _OLDER:
            importlib.import_module(f"synth.motion.importers.{module.name}")
    return dict(sorted(_formats.items()))


_OLDER = ("c3d", "deeplabcut", "matlab", "opensim", "plain_csv")  # loaders whose modules have the format's name


def recognise(path: Path, name: str, *, points: bool = False) -> ForeignFormat:
    """The format of a file, from its content; ``points`` : whether points are asked for, of a table that may hold them.

    Raises
    ------
    UserError
        If there is none, with the known ones; or if there are several, with how to choose.
    """
    try:
        size_of_regular(path, name)
        with path.open("rb") as stream:
            start = stream.read(START)
    except FileNotFoundError:
        raise UserError(Problem("does not exist", name)) from None
    except OSError as error:
        raise UserError(Problem(f"cannot be read: {error.strerror}", name)) from None
    known = formats()
    found = [item for item in known.values() if not item.last and item.holds(start, path)]
    wanted = "points" if points else "channels"
    found = found or [item for item in known.values() if item.last and item.gives == wanted and item.holds(start, path)]
    if len(found) == 1:
        return found[0]
    if found:
        several = " and ".join(item.name for item in found)
        raise UserError(Problem(f"may be {several}; choose one in a project: format: {found[0].name}", name))
    raise UserError(Problem(f"{_unknown_format(start)}; known formats: {', '.join(known)} (synth import --list)", name))


def _unknown_format(start: bytes) -> str:
    """A description of an unknown file, from its first bytes."""
    if start.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        return "is a spreadsheet or an archive; export it as CSV"
    if start.startswith(HDF5):
        known = ", ".join(item.name for item in formats().values() if item.extra in HDF5_EXTRAS)
        return f"is HDF5 of an unknown program; if it is of a known one, state it in a project, format: one of {known}"
    return "has an unknown format" if start else "is empty"


def text_start(start: bytes) -> str:
    """The first bytes as text; empty if they are not text."""
    if start.startswith(UTF_16):
        return start.decode("utf-16", errors="replace")
    if b"\0" in start[:4000] or start.startswith(HDF5):  # a text has no zero byte, a binary file has one soon
        return ""
    return start.decode("utf-8-sig", errors="replace")


def utf8(data: bytes) -> bytes:
    """A text in UTF-16, as some spreadsheets and shells write it, in UTF-8; other data as they are."""
    if not data.startswith(UTF_16):
        return data
    try:
        return data.decode("utf-16").encode()
    except UnicodeDecodeError:
        return data  # the reader refuses it as no text


def hdf5_names(path: Path, *words: bytes) -> bool:
    """Whether all words stand in the first or last bytes of a file, which may be far larger than the memory."""
    with path.open("rb") as stream:
        start = stream.read(SCANNED)
        stream.seek(max(SCANNED, path.stat().st_size - SCANNED))
        end = stream.read(SCANNED)
    return all(word in start or word in end for word in words)
