"""What a foreign file holds once it is read: channels of numbers, or points in space."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.validate import near

SHOWN = 40  # names in a message


@dataclass(frozen=True, eq=False)
class Channels:
    """Numbers over time, such as joint angles.

    ``values`` (n, n_channel) as in the file, nan where missing; ``units`` a unit for each channel, "" where the file
    says none; ``time`` (n,) s or None where the clock is one of the channels or there is none; ``notes`` what reading
    the file showed.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    time: Array | None = None
    notes: tuple[str, ...] = ()
    units_fixed: bool = False  # the file itself decides on the units: a project that says another is mistaken

    def find(self, wanted: str, what: str) -> int:
        """The index of a channel.

        Raises
        ------
        UserError : there is none, or several, with what there is.
        """
        exact = [index for index, name in enumerate(self.names) if name == wanted]
        found = exact or [index for index, name in enumerate(self.names) if same_name(name, wanted)]
        if len(found) == 1:
            return found[0]
        if found:
            several = ", ".join(self.names[index] for index in found)
            raise UserError(Problem(f'{what}: "{wanted}" is the name of several columns: {several}', self.name))
        hint = near(wanted, self.names)
        hint = hint if hint.startswith("; did you mean") else f"; the file has {listed(self.names)}"
        raise UserError(Problem(f'{what}: there is no column "{wanted}"{hint}', self.name))


@dataclass(frozen=True, eq=False)
class Markers:
    """Points over time, in a plane (x to the right, z up) or in space (x, y, z as in the file).

    ``positions`` (n, n_point, 2 or 3), nan where missing; ``frames`` (n,) the file's own count; ``frame_rate`` Hz or
    None where the file has no clock; ``unit`` of the positions. ``up`` : the axis that is up in space by the format's
    own habit, with which the plane may be fitted; None: it must be said.
    """

    name: str
    names: tuple[str, ...]
    positions: Array
    frames: Array
    frame_rate: float | None
    unit: str
    notes: tuple[str, ...] = ()
    up: str | None = None

    def find(self, wanted: str) -> int:
        """The index of a point; raises UserError with the points that there are."""
        exact = [index for index, name in enumerate(self.names) if name == wanted]
        found = exact or [index for index, name in enumerate(self.names) if same_name(name, wanted)]
        if len(found) == 1:
            return found[0]
        hint = near(wanted, self.names)
        hint = hint if hint.startswith("; did you mean") else f"; the file has {listed(self.names)}"
        raise UserError(Problem(f'there is no point "{wanted}"{hint}', self.name))


Source = Channels | Markers


def listed(names: Iterable[str]) -> str:
    """Names in a row, cut where there are many."""
    every = list(names)
    return ", ".join(every[:SHOWN]) + (f" ... ({len(every)} in all)" if len(every) > SHOWN else "")


def same_name(one: str, other: str) -> bool:
    """Alike but for case, blanks, underscores and a path before the name."""
    return _plain(one) == _plain(other)


def _plain(name: str) -> str:
    parts = [part for part in name.split("/") if part]
    if len(parts) > 1 and parts[-1] == "value":  # OpenSim 4: /jointset/knee_r/knee_angle_r/value
        parts = parts[:-1]
    return re.sub(r"[\s_-]+", "", parts[-1] if parts else name).casefold()


_SIDES = (("left", "right"), ("l", "r"))


def other_side(name: str, names: Sequence[str]) -> int | None:
    """The index of the same point or column on the body's other side, by its name; None where there is none."""
    for pair in _SIDES:
        for here, there in (pair, pair[::-1]):
            pattern = rf"(?<![a-z]){here}(?![a-z])" if len(here) == 1 else here
            for match in re.finditer(pattern, name.casefold()):
                swapped = name.casefold()[: match.start()] + there + name.casefold()[match.end() :]
                found = [index for index, other in enumerate(names) if other.casefold() == swapped]
                if len(found) == 1:
                    return found[0]
    return None
