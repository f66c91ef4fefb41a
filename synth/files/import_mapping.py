"""How a foreign file's columns or points become a leg's angles: what an import project states of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from synth.swing.leg_model import Joint

DRIVEN = {"command": "rad", "voltage": "V", "current": "A", "torque": "N*m", "enabled": "1"}  # a drive's inputs


@dataclass(frozen=True)
class InputColumn:
    """A column of a drive's input, and its unit if the file states none.

    ``counts``, ``gear_ratio`` : of a command, as in ``JointColumn``; None: as the angle's.
    """

    column: str
    unit: str | None = None
    counts: int | None = None
    gear_ratio: float | None = None


@dataclass(frozen=True)
class CommandTopic:
    """A topic of a robot's log with commands; ``joints`` in the order of its numbers where these bear no names."""

    topic: str
    joints: tuple[str, ...] = ()


@dataclass(frozen=True)
class JointColumn:
    """The column of a joint's angle, and its convention.

    ``zero`` : rad, the file's reading when this link points along its parent (the first: straight down); None and
        ``sign`` None: as the leg's own. ``inputs`` : the columns of its drive, by the names in ``DRIVEN``.
    ``counts`` : an encoder's raw counts in one of its turns; None: the column has a unit. ``gear_ratio`` : turns of the
        encoder in one of the joint; ``zero`` is the joint's angle, behind the gear. ``segment`` : the angle is that of
        the link itself in space; ``zero`` is then the reading when it hangs straight down, and ``sign`` None is +1.
    ``quaternion`` : the four columns w, x, y, z of a segment's sensor in the place of ``column``, which is then what
        messages call them; a ``-`` before a name turns its sign. ``axis``, ``down`` : in the sensor's own axes, the
        hinge's axis towards the viewer and the direction of the link from its joint outward; ``axis`` None: not stated.
    """

    column: str
    unit: str | None = None
    zero: float | None = None
    sign: int | None = None
    inputs: dict[str, InputColumn] = field(default_factory=dict)
    counts: int | None = None
    gear_ratio: float = 1.0
    segment: bool = False
    quaternion: tuple[str, ...] = ()
    axis: tuple[float, ...] | None = None
    down: tuple[float, ...] = ()

    def convention(self, joint: Joint) -> tuple[float, int]:
        """Zero, rad, and sign of the column's readings."""
        zero = joint.zero if self.zero is None else self.zero
        sign = 1 if self.segment else joint.sign
        return zero, sign if self.sign is None else self.sign

    def of_joint(self, joint: Joint) -> tuple[float, int]:
        """Zero, rad, and sign of further columns that tell of the joint itself; beside a segment's the leg file's."""
        return (joint.zero, joint.sign) if self.segment else self.convention(joint)


@dataclass(frozen=True)
class Mapping:
    """The conversion of a foreign file into a leg's angles; each format uses the options it needs.

    ``time`` : the clock's column; ``time_unit`` : its unit. ``frame_rate`` : Hz, if the file has no clock.
    ``joints`` : one column each. ``points`` : proximal to distal, one more than joints. ``likelihood`` : less likely
    points count as missing. ``plane`` : axes of space to the right and up; ``fit`` and an axis: the best-fitting plane
    with that axis up. ``topic`` : of a robot's log. ``mirror`` : seen from the other side.
    ``roll`` : rad, counter-clockwise rotation of the picture as filmed, before ``mirror``. ``supply`` : the column of
    the drives' supply. ``commands`` : topics of commands in a robot's log. ``towards`` : of a fitted plane, the level
    direction (2,) on whose side right is, in the axes that are not up; found from all files of a project, not stated.
    """

    time: str | None = None
    time_unit: str | None = None
    frame_rate: float | None = None
    joints: dict[str, JointColumn] = field(default_factory=dict)
    points: tuple[str, ...] = ()
    individual: str | None = None
    likelihood: float | None = None
    plane: tuple[str, str] | None = None
    mirror: bool = False
    roll: float = 0.0
    topic: str | None = None
    supply: InputColumn | None = None
    commands: tuple[CommandTopic, ...] = ()
    towards: tuple[float, float] | None = None
