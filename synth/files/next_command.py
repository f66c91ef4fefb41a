"""What a suggested command may ask of a leg: ``next_command:`` of a project of kind ``gap``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import radians
from typing import Annotated, Any

from pydantic import Field

from synth.files.named_files import ProjectReader
from synth.files.validate import Quantity
from synth.swing.leg_model import Leg

TURNS = radians(3600)  # rad; a command beyond ten turns is a slip of units
USUAL = 6.0  # s: as long as the logs of the servo benches examined
# s; with less no joint has moved, and more takes minutes of computing.
SHORTEST, LONGEST = 0.5, 60.0


@dataclass(frozen=True)
class JointLimits:
    """Limits of one joint: commanded angle (rad, as measured), its speed (rad/s) and the motor's torque (N m).

    None: as in the trials so far; for the torque: none.
    """

    lowest: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)] | None = None
    highest: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)] | None = None
    speed: Annotated[float, Quantity("rad/s", above=0)] | None = None
    torque: Annotated[float | None, Quantity("N*m", above=0), Field(examples=["0.8 N*m"])] = None


@dataclass(frozen=True)
class NextCommandKeys:
    """As written."""

    length: Annotated[float, Quantity("s", least=SHORTEST, most=LONGEST), Field(examples=["4 s"])] = USUAL
    limits: Any = None


@dataclass(frozen=True)
class NextCommand:
    """A suggested command's ``length`` in s, and joint -> its limits where the project states them."""

    length: float = USUAL
    limits: Mapping[str, JointLimits] = field(default_factory=dict)


def read_next_command(reader: ProjectReader, written: Any, leg: Leg | None) -> NextCommand:
    """From ``next_command: {length: 4 s, limits: {knee: {lowest: -20 deg, speed: 200 deg/s}}}``."""
    if written is None:
        return NextCommand()
    file = reader.entry(NextCommandKeys, ("next_command",), written)
    limits = None if file is None else file.limits
    if file is None or limits is None:
        return NextCommand() if file is None else NextCommand(file.length)
    if not isinstance(limits, Mapping):
        text = f"{limits!r} is no mapping of joints: write limits: {{knee: {{speed: 200 deg/s}}}}"
        reader.refuse(text, ("next_command", "limits"))
        return NextCommand(file.length)
    if leg is not None:
        reader.known_joints(limits, leg, ("next_command", "limits"))
    found = {}
    for joint, value in limits.items():
        key = ("next_command", "limits", str(joint))
        entry = reader.entry(JointLimits, key, value)
        if entry is None:
            continue
        if entry.lowest is not None and entry.highest is not None and entry.lowest >= entry.highest:
            reader.refuse("lowest is not below highest", key)
        found[str(joint)] = entry
    return NextCommand(file.length, found)
