"""Static points: poses in which springs, gravity and a known torque balance.

Under ``static:`` in a project, a list of such mappings:

.. code-block:: yaml

    static:
      - {angles: {hip: 125 deg, knee: 118 deg, ankle: 139 deg}, torque: {hip: 1.9 N*m}}  # held there by a known torque
      - {angles: {hip: 99 deg, knee: 110 deg, ankle: 133 deg}, tip_mass: 200 g}          # at rest with a mass on it
      - {angles: {hip: 140 deg}, torque: {hip: 1.4 N*m}, supported: true}                # the spring alone

``angles``: the measured angle of every joint, because the leg's weight at a joint depends on the whole pose; if
the leg is ``supported`` (carried, or removed) the joints with a torque suffice. ``torque``: joints on which a known
torque acts, in the measured angle's positive sense, zero for the others. The balance is evaluated at the joints
under ``torque``, or at all if there is none, but never at those that are ``locked``. ``tip_mass`` and ``tilt`` as in
a trial. ``torque_error`` and ``angle_error`` are standard deviations, by default 2 % of the spring's torque and 0.5
deg. Where the free angle shifts from trial to trial, a point's is taken to be shifted as much; points of one
``session`` share the shift (see ``fit.static_points``). A point that contradicts the recordings is named and left out
(``fit.point_check``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synth.arrays import Array
from synth.errors import Problem
from synth.files.leg_keys import TURNS
from synth.files.validate import FileModel, Quantity, check_part, near
from synth.files.yaml_lines import Document, Key
from synth.swing.leg_model import Leg

POINT_LIMIT = 1000  # of a project; typed poses are tens
ANGLE_ERROR = radians(0.5)  # rad, default: a careful reading of a protractor
TORQUE_SHARE = 0.02  # of the spring's torque: a hand-held force gauge or a kitchen balance on a lever

Angle = Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)]


@dataclass(frozen=True, eq=False)
class StaticPoint:
    """One pose in equilibrium, SI and measured angles.

    ``angles`` (n,) rad, nan where not given; ``torques`` (n,) N m in the measured angles' positive sense; ``balanced``
    the indices of the joints at which the balance holds; ``torque_error`` N m, None for ``TORQUE_SHARE`` of the
    spring's torque; ``session`` the name of those measured in one go, with one free angle, None where it is not said.
    """

    name: str
    angles: Array
    torques: Array
    balanced: tuple[int, ...]
    tip_mass: float = 0.0
    tilt: float = 0.0
    supported: bool = False
    torque_error: float | None = None
    angle_error: float = ANGLE_ERROR
    session: str | None = None


class _PointEntry(FileModel):
    """One item under ``static:``."""

    angles: Annotated[dict[str, Angle], Field(min_length=1, examples=["{hip: 125 deg, knee: 118 deg}"])]
    torque: dict[str, Annotated[float, Quantity("N*m")]] = Field(default_factory=dict)
    locked: list[str] = Field(default_factory=list)
    supported: bool = False
    tip_mass: Annotated[float, Quantity("kg", least=0)] = 0.0
    tilt: Annotated[float, Quantity("rad", least=-radians(360), most=radians(360))] = 0.0
    torque_error: Annotated[float, Quantity("N*m", above=0)] | None = None
    angle_error: Annotated[float, Quantity("rad", above=0, most=radians(45))] = ANGLE_ERROR
    session: Annotated[str | None, Field(examples=["monday"])] = None


def read_static_points(
    entries: Any, leg: Leg, document: Document, key: Key, problems: list[Problem]
) -> tuple[StaticPoint, ...]:
    """The points listed at ``key``; mistakes go to ``problems`` and their points are left out."""
    if not isinstance(entries, list) or not entries:
        text = "a list of points is needed, for example [{angles: {hip: 125 deg, ...}, torque: {hip: 1.9 N*m}}]"
        problems.append(document.problem(text, key))
        return ()
    if len(entries) > POINT_LIMIT:
        problems.append(document.problem(f"more than {POINT_LIMIT} points; average repeated readings", key))
        return ()
    points = []
    for index, value in enumerate(entries):
        place = (*key, index)
        entry = check_part(_PointEntry, document, value, place, problems)
        if entry is None:
            continue
        found = _problems(entry, leg, document, place)
        problems += found
        if not found:
            points.append(_point(entry, leg, f"static[{index + 1}]"))
    return tuple(points)


def _problems(entry: _PointEntry, leg: Leg, document: Document, place: Key) -> list[Problem]:
    """Contradictions with the leg, and missing angles."""
    names, problems = leg.joint_names, []
    for what, given in (("angles", entry.angles), ("torque", entry.torque), ("locked", entry.locked)):
        for name in given:
            if name not in names:
                text = f'"{name}" is no joint of {leg.name}{near(name, names)}'
                problems.append(document.problem(text, (*place, what, *((name,) if what != "locked" else ()))))
    if problems:
        return problems
    missing = [name for name in names if name not in entry.angles]
    if missing and not entry.supported:
        text = (
            f"the angle of {_listed(missing)} is missing: the weight at a joint depends on the whole pose. Give "
            'every joint\'s angle, or write "supported: true" if the leg was supported and only the spring acts'
        )
        problems.append(document.problem(text, (*place, "angles")))
    unseen = [name for name in entry.torque if name in missing]
    if unseen and entry.supported:
        problems.append(document.problem(f"the angle of {_listed(unseen)} is missing", (*place, "angles")))
    held = [name for name in entry.torque if name in entry.locked]
    if held:
        text = f"{_listed(held)} is locked but has a torque: a locked joint balances any torque"
        problems.append(document.problem(text, (*place, "locked")))
    if entry.supported and (entry.tip_mass or entry.tilt):
        text = 'the leg is "supported", so "tip_mass" and "tilt" have no effect; leave one out'
        problems.append(document.problem(text, (*place, "supported")))
    if not problems and not _balanced(entry, leg):
        problems.append(document.problem("every joint is locked: no balance remains", place))
    return problems


def _balanced(entry: _PointEntry, leg: Leg) -> tuple[int, ...]:
    wanted: Sequence[str] = list(entry.torque) or list(entry.angles)
    return tuple(j for j, name in enumerate(leg.joint_names) if name in wanted and name not in entry.locked)


def _point(entry: _PointEntry, leg: Leg, name: str) -> StaticPoint:
    angles = np.array([entry.angles.get(joint, np.nan) for joint in leg.joint_names])
    torques = np.array([entry.torque.get(joint, 0.0) for joint in leg.joint_names])
    return StaticPoint(
        name,
        angles,
        torques,
        _balanced(entry, leg),
        entry.tip_mass,
        entry.tilt,
        entry.supported,
        entry.torque_error,
        entry.angle_error,
        entry.session,
    )


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
