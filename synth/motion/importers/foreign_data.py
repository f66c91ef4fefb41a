"""The content of a foreign file: channels of numbers, or points in space."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.validate import near
from synth.units import factor

# Cells of a table that stand for a missing value
MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-nan", "nan(ind)"})
NAMES_SHOWN = 40  # names in a message: all points of most trackers


@dataclass(frozen=True, eq=False)
class Channels:
    """Numbers over time, such as joint angles.

    ``values`` (n, n_channel) as in the file, nan if missing; ``units`` of each channel, "" if the file
    states none; ``time`` (n,) s or None if the clock is one of the channels or missing; ``notes`` messages of the
    reader. ``inputs`` : further channels with clocks of their own, from the same zero; ``hint`` : why there are no
    commands among them. ``numbers`` : gives a channel's values by its index with all the file's digits, for clocks.
    ``contents`` : what the file has, in messages, if that is more than the names; ``refused`` : names of what it has
    and what is wrong with it, as "in record 8 it is the text ...". ``begins`` : s, the file's own time
    at the zero of its clocks, if the reader has set a large one (``log_clock``) to 0. ``called`` : what the file's
    header calls channels that bear a joint's name because other cells tell it.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    time: Array | None = None
    notes: tuple[str, ...] = ()
    units_fixed: bool = False  # the file determines the units: a different one in a project is a mistake
    inputs: tuple[Channels, ...] = ()
    hint: str = ""
    numbers: Callable[[int], Sequence[Any]] | None = None
    contents: str = ""
    begins: float = 0.0
    refused: Mapping[str, str] = field(default_factory=dict)
    called: Mapping[str, str] = field(default_factory=dict)

    def has(self, wanted: str) -> bool:
        """Whether there is exactly one channel of that name."""
        return len(indices_of_name(wanted, self.names)) == 1

    def find(self, wanted: str, what: str) -> int:
        """The index of a channel.

        Raises
        ------
        UserError : there is none, or several; the message lists the names.
        """
        found = indices_of_name(self.called.get(wanted, wanted), self.names)
        if len(found) == 1:
            return found[0]
        if found:
            several = ", ".join(self.names[index] for index in found)
            raise UserError(ColumnProblem(f'{what}: "{wanted}" is the name of several columns: {several}', self.name))
        refused = [list(self.refused)[index] for index in indices_of_name(wanted, tuple(self.refused))]
        if refused:
            text = f'{what}: the column "{refused[0]}" is not all numbers: {self.refused[refused[0]]}'
            raise UserError(Problem(text, self.name))
        hint = near(wanted, [*self.names, *self.refused])
        hint = hint if hint.startswith("; did you mean") else f"; the file has {self.contents or name_list(self.names)}"
        raise UserError(ColumnProblem(f'{what}: there is no column "{wanted}"{hint}', self.name))

    def unit(self, index: int, stated: str | None, what: str, example: str, otherwise: str = "") -> str:
        """The unit of a channel: the file's own, or the project's if the file states none.

        ``what`` : the channel is for, in messages; ``example`` : a unit that would do, ``s`` for a clock; ``otherwise``
        : what else the project may state.
        """
        own, title = self.units[index], self.names[index]
        if stated is not None and own and abs(factor(stated, own) - 1.0) > 1e-12:
            place = "the header's inDegrees" if self.units_fixed else "the file"
            text = f'{what}: {place} says that "{title}" is in {own}, the project says {stated}; leave `unit` out'
            raise UserError(Problem(text, self.name))
        unit = own or stated
        if not unit:
            text = f'{what}: the file does not state the unit of "{title}"; write {{column: {title}, unit: {example}}}'
            raise UserError(ColumnProblem(text + otherwise, self.name))
        canonical = "s" if example == "s" else "rad"
        try:
            factor(unit, canonical)
        except UserError as error:
            raise UserError(Problem(f"{what}: {error.problems[0].text}", self.name)) from None
        return unit


@dataclass(frozen=True)
class ColumnProblem(Problem):
    """A mistake that an import project mends, which names a column or its unit."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Points over time, in a plane (x to the right, z up) or in space (x, y, z as in the file).

    ``positions`` (n, n_point, 2 or 3), nan where missing; ``frames`` (n,) the file's own count; ``frame_rate`` Hz or
    None if the file has no clock; ``unit`` of the positions. ``up`` : the upward axis in space by the format's
    convention, for fitting the plane; None: it must be stated. ``time`` (n,) s, None if it is frames over rate.
    ``picture`` : of points in a plane as in the file, their axes to the right and up; a project's ``plane`` replaces
    them. None: they are turned so already, and there is nothing to state.
    """

    name: str
    names: tuple[str, ...]
    positions: Array
    frames: Array
    frame_rate: float | None
    unit: str
    notes: tuple[str, ...] = ()
    up: str | None = None
    time: Array | None = None
    picture: tuple[str, str] | None = None

    def find(self, wanted: str) -> int:
        """The index of a point; raises UserError with the existing points.

        Capture systems write a subject before the name, ``Rat:hip``: the name alone is enough where it is the only one.
        """
        alone = tuple(name.rpartition(":")[2] for name in self.names)
        found = indices_of_name(wanted, self.names) or indices_of_name(wanted, alone)
        if len(found) == 1:
            return found[0]
        if found:
            several = name_list(self.names[index] for index in found)
            raise UserError(Problem(f'"{wanted}" is the name of several points: {several}', self.name))
        hint = near(wanted, self.names)
        hint = hint if hint.startswith("; did you mean") else f"; the file has {name_list(self.names)}"
        raise UserError(Problem(f'there is no point "{wanted}"{hint}', self.name))


Source = Channels | Markers


def name_list(names: Iterable[str]) -> str:
    """Names as a list, shortened if long."""
    every = list(names)
    return ", ".join(every[:NAMES_SHOWN]) + (f" ... ({len(every)} in all)" if len(every) > NAMES_SHOWN else "")


def states_otherwise(text: str, count: int) -> bool:
    """Whether a header's text is a whole number other than ``count``; of other text, and of none, no."""
    return text.isascii() and text.isdigit() and (text.lstrip("0") or "0") != str(count)


def cut_off(stated: str | int, found: int, what: str, name: str) -> Problem:
    """The message on a file whose header states another number of ``what``, such as rows, than it has."""
    text = f"its header says {stated} {what} and there are {found}: the file is cut off or was edited; copy or export "
    return Problem(text + "it again, or correct its header", name)


def same_name(one: str, other: str) -> bool:
    """Equal except for case, blanks, underscores and a path before the name."""
    return _parts(one)[-1] == _parts(other)[-1]


def indices_of_name(wanted: str, names: Sequence[str]) -> list[int]:
    """The indices of names that are the wanted one: exactly, else except for case, blanks, underscores and a path.

    A path ends with the name, or goes on to what it is of (``/joint_states/hip/position``). Where paths lead to things
    of that name in several places (``/setpoint/hip`` too), all are given, for which is meant is not known.
    """
    exact = [index for index, name in enumerate(names) if name == wanted]
    plain = [_parts(name) for name in names]
    last = _parts(wanted)
    found = exact or [index for index, parts in enumerate(plain) if parts == last]
    if found:
        return found
    places: dict[tuple[str, ...], list[int]] = {}
    for index, parts in enumerate(plain):
        ends = [end for end in range(len(last), len(parts) + 1) if parts[end - len(last) : end] == last]
        if ends:
            places.setdefault(parts[: ends[-1]], []).append(index)
    # A joint may hold a coordinate of its own name (OpenSim: /jointset/hip/hip/value): the deepest is meant.
    deepest = [place for place in places if not any(_above(place, other) for other in places)]
    readings = [[k for k in places[place] if plain[k][len(place) :] in _READING] for place in deepest]
    if len(deepest) == 1 or not any(readings):
        return [k for own in readings for k in own]
    return [k for place, own in zip(deepest, readings, strict=True) for k in own or places[place]]


def _above(place: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Whether the other path leads on from a place."""
    return len(place) < len(other) and other[: len(place)] == place


# After a name in a header: no unit, but what the project's counts a turn are for.
_COUNTS = re.compile(r"\s*[\[(]\s*(counts?|cts|ticks?|pulses?|lsb)(\s*/\s*s(ec)?)?\s*[\])]$", re.IGNORECASE)
_READING = ((), ("value",), ("position",))  # after a joint's name in the paths of OpenSim 4 and of joint states


def _parts(name: str) -> tuple[str, ...]:
    """The parts of a path, of a plain name one, without case, blanks, underscores, dashes, comment marks, [counts]."""
    whole = re.sub(r"^\s*[#%]+\s*(?=\S)", "", name)  # %time: the first name of a header that is a comment
    whole = _COUNTS.sub("", whole)
    parts = [re.sub(r"[\s_-]+", "", part).casefold() for part in whole.split("/") if part]
    return tuple(parts) or (name,)


_OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}
_WORDS = ("left|right", r"(?<![a-z])[lr](?![a-z])")  # of a name in small letters
_ATTACHED = (r"(?<![a-z])[lr](?=[a-z])", r"(?<=[a-z])[lr](?![a-z])")


def other_side(name: str, names: Sequence[str]) -> int | None:
    """The index of the same point or column on the body's other side, by its name; None if there is none.

    ``left hip``, ``hip_l``; and ``RHIP``, ``HipR``, where a second pair of the file is named so too.
    """
    found = _partner(name, names, _WORDS)
    if found is not None:
        return found
    for attached in _ATTACHED:
        found = _partner(name, names, (attached,))
        if found is not None and sum(_partner(other, names, (attached,)) is not None for other in names) >= 4:
            return found
    return None


def _partner(name: str, names: Sequence[str], patterns: Sequence[str]) -> int | None:
    """The index of the one name that differs from ``name`` in the side that a pattern finds."""
    folded = name.casefold()
    for pattern in patterns:
        for match in re.finditer(pattern, folded):
            swapped = folded[: match.start()] + _OTHER[match[0]] + folded[match.end() :]
            found = [index for index, other in enumerate(names) if other.casefold() == swapped]
            if len(found) == 1:
                return found[0]
    return None
