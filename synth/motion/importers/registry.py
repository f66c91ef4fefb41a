"""Foreign formats: one decorated loader and one validator of the content each, found by looking.

A module of this package that decorates its loader with ``loader`` is a format; nothing else lists them. Which format a
file has is asked of its content, never of its ending: every validator looks at it.
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
from synth.files.import_project import Mapping
from synth.motion.importers.foreign_data import Source

START = 200_000  # bytes of a file that validators are shown
HDF5 = b"\x89HDF\r\n\x1a\n"
Reader = Callable[[Path, Mapping, str], Source]
Holds = Callable[[bytes, Path], bool]  # the file's first bytes, and the file for those who must look further


@dataclass(frozen=True)
class ForeignFormat:
    """A format.

    ``holds`` : whether a file is of it. ``gives`` : joint angles or the like, or points. ``space`` : its points may lie
    in space, so ``plane`` means something. ``keys`` : further keys of a project that mean something for it.
    ``package`` : what reads it, None where nothing is needed; ``extra`` : the extra of this program that brings it.
    ``own_clock`` : its clock is the file's, and none may be told. ``last`` : taken only where no other holds, since
    nearly every text would pass.
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
        """Whether what it needs is there."""
        return self.package is None or find_spec(self.package) is not None

    def require(self, name: str) -> None:
        """Raise UserError where its package is missing."""
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
    """Every format by its name, in alphabetical order."""
    package = importlib.import_module("synth.motion.importers")
    for module in pkgutil.iter_modules(package.__path__):
        if module.name.startswith("from_") or module.name in _OLDER:
            importlib.import_module(f"synth.motion.importers.{module.name}")
    return dict(sorted(_formats.items()))


_OLDER = ("c3d", "deeplabcut", "matlab", "opensim", "plain_csv")  # loaders whose modules have the format's own name


def recognise(path: Path, name: str) -> ForeignFormat:
    """The one format that a file's content is of.

    Raises
    ------
    UserError
        Where it is of none, with what is known; where it is of several, with how to choose.
    """
    try:
        with path.open("rb") as stream:
            start = stream.read(START)
    except FileNotFoundError:
        raise UserError(Problem("does not exist", name)) from None
    except OSError as error:
        raise UserError(Problem(f"cannot be read: {error.strerror}", name)) from None
    known = formats()
    found = [item for item in known.values() if not item.last and item.holds(start, path)]
    found = found or [item for item in known.values() if item.last and item.holds(start, path)]
    if len(found) == 1:
        return found[0]
    if found:
        several = " and ".join(item.name for item in found)
        raise UserError(Problem(f"may be {several}; say which in a project: format: {found[0].name}", name))
    raise UserError(Problem(f"{_stranger(start)}; known are {', '.join(known)} (synth import --list)", name))


def _stranger(start: bytes) -> str:
    """What a file is that none of ours is, as far as its first bytes tell."""
    if start.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        return "is a spreadsheet or an archive; export it as CSV"
    if start.startswith(HDF5):
        return "is HDF5 of another program than those that are known"
    return "is of no format that is known" if start else "is empty"


def text_start(start: bytes) -> str:
    """The first bytes as text, empty where they are none."""
    if b"\0" in start[:4000] or start.startswith(HDF5):
        return ""
    return start.decode("utf-8-sig", errors="replace")
