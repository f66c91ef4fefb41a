"""A limb as data: a planar chain of rigid links with a spring and a damper at each joint.

Everything is SI with angles in radians. *Measured* angles are what a file holds; *rotations* q are the
chain's own coordinates, counter-clockwise positive, zero with the link along its parent (the first:
straight down): ``q = sign * (measured - zero)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from synth.arrays import Array
from synth.drives.servo import Servo, TorqueDrive


@dataclass(frozen=True)
class Link:
    """A rigid link. ``com`` is measured from the proximal joint along the link; ``inertia`` is about the com.

    ``includes``: whether the figures hold the parts of the link's joints already; only a design asks.
    """

    length: float  # m
    mass: float  # kg
    com: float  # m
    inertia: float  # kg m^2
    includes: Literal["none", "joint"] = "joint"


@dataclass(frozen=True)
class Tip:
    """What one trial adds to the last link: ``mass`` with ``inertia`` about its own centre, ``at`` from the joint.

    ``at`` None: at the link's end.
    """

    mass: float = 0.0  # kg
    inertia: float = 0.0  # kg m^2
    at: float | None = None  # m

    def place(self, length: Array | float) -> Array:
        """Distance from the last joint along its link, m; ``length`` m of that link."""
        return np.asarray(length if self.at is None else np.full_like(np.asarray(length, dtype=float), self.at))


@dataclass(frozen=True)
class Spring:
    """A linear torsion spring: torque on q is ``-rate * (q - sign * (free_angle - zero))``."""

    rate: float  # N m/rad
    free_angle: float  # rad, measured angle at which the spring is unloaded
    part: str | None = None  # catalogue part that it stands for


@dataclass(frozen=True)
class DamperCurve:
    """An odd torque-speed curve, linear between its points and along its last segment beyond them.

    ``speed`` and ``torque``: (n_point,) rad/s and N m, strictly increasing speeds > 0; (0, 0) is implied.
    """

    speed: tuple[float, ...]
    torque: tuple[float, ...]


@dataclass(frozen=True)
class Damper:
    """A rotary damper: a linear ``rate`` or a ``curve``; never both."""

    rate: float | None = None  # N m s/rad
    curve: DamperCurve | None = None
    part: str | None = None


@dataclass(frozen=True)
class Joint:
    """A hinge with the link that hangs from it.

    ``effects``: name of the effect -> its parameters in SI, e.g. ``{"coulomb_friction": {"torque": 0.05}}``.
    """

    name: str
    link: Link
    zero: float = 0.0  # rad
    sign: int = 1
    range: tuple[float, float] | None = None  # rad, measured
    spring: Spring | None = None
    damper: Damper | None = None
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    armature: float = 0.0  # kg m^2, that turns with the joint itself, beside the rotor of its ``drive``
    drive: Servo | TorqueDrive | None = None

    @property
    def rest(self) -> float:
        """Rotation q at which the spring is unloaded, rad; 0 without a spring."""
        return self.sign * (self.spring.free_angle - self.zero) if self.spring is not None else 0.0

    @property
    def with_rotor(self) -> float:
        """Inertia that turns with the joint itself, kg m^2: its armature and the rotor of its drive."""
        rotor = self.drive.motor.armature if self.drive is not None and self.drive.motor is not None else 0.0
        return self.armature + rotor

    @property
    def ends(self) -> tuple[float, float] | None:
        """Least and greatest rotation q of the range, rad; None where there is no range."""
        if self.range is None:
            return None
        low, high = sorted(self.sign * (angle - self.zero) for angle in self.range)
        return low, high


@dataclass(frozen=True)
class Leg:
    """A chain of 1 to 6 links, proximal to distal."""

    name: str
    joints: tuple[Joint, ...]
    gravity: float = 9.81  # m/s^2
    tilt: float = 0.0  # rad, rotation of the whole base, counter-clockwise positive
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # of the base

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Proximal to distal."""
        return tuple(joint.name for joint in self.joints)

    @property
    def zero(self) -> Array:
        """(n_joint,) rad, the measured angles of the straight leg."""
        return np.array([joint.zero for joint in self.joints])

    @property
    def sign(self) -> Array:
        """(n_joint,) +1 or -1."""
        return np.array([float(joint.sign) for joint in self.joints])

    @property
    def rest(self) -> Array:
        """(n_joint,) rad, rotations q at which the springs are unloaded; 0 where there is none."""
        return np.array([joint.rest for joint in self.joints])

    @property
    def spring_rate(self) -> Array:
        """(n_joint,) N m/rad; 0 where there is no spring."""
        return np.array([joint.spring.rate if joint.spring is not None else 0.0 for joint in self.joints])

    @property
    def armature(self) -> Array:
        """(n_joint,) kg m^2 that turn with each joint itself."""
        return np.array([joint.with_rotor for joint in self.joints])

    @property
    def total_length(self) -> float:
        """Summed link lengths, m."""
        return sum(joint.link.length for joint in self.joints)

    def to_rotation(self, measured: Array) -> Array:
        """Measured angles (..., n_joint) rad to rotations q (..., n_joint) rad."""
        return self.sign * (measured - self.zero)

    def to_measured(self, rotation: Array) -> Array:
        """Rotations q (..., n_joint) rad to measured angles (..., n_joint) rad."""
        return self.zero + self.sign * rotation

    def with_joints(self, **changes: Mapping[str, object]) -> Leg:
        """A copy with fields of the named joints replaced, ``leg.with_joints(knee={"spring": spring})``."""
        joints = [
            replace(joint, **changes[joint.name]) if joint.name in changes else joint  # type: ignore[arg-type]
            for joint in self.joints
        ]
        return replace(self, joints=tuple(joints))
