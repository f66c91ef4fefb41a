"""A limb as data: a planar chain of rigid links with a spring and a damper at each joint.

All quantities are in SI, angles in radians. *Measured* angles are those in files. *Rotations* q are the coordinates of
the chain: counter-clockwise positive, zero when the link is aligned with its parent (the first link: straight down).
``q = sign * (measured - zero)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from synth.arrays import Array
from synth.drives.servo import Servo, TorqueDrive, lightened

# Of the link's own inertia about its joint, the most that a winding's lag takes: more would leave the first order, in
# which a torque of a little earlier is an inertia.
MOST_LAGGED = 0.5
AT_STOP = 1e-6  # rad, from the end of a range: what a table's digits leave


@dataclass(frozen=True)
class Link:
    """A rigid link. ``com`` is measured from the proximal joint along the link; ``inertia`` is about the com.

    ``com_across`` : distance of the com from the link's line, positive on the side to which q grows: that to the right
    of a link that hangs down.
    ``includes`` : whether mass, com and inertia already include the parts of the link's joints; used by designs only.
    """

    length: float  # m
    mass: float  # kg
    com: float  # m
    inertia: float  # kg m^2
    includes: Literal["none", "joint"] = "joint"
    com_across: float = 0.0  # m

    @property
    def about_joint(self) -> float:
        """Inertia about the proximal joint, kg m^2."""
        return self.inertia + self.mass * (self.com**2 + self.com_across**2)


@dataclass(frozen=True)
class Tip:
    """A mass that one trial adds to the last link.

    ``inertia`` : about the centre of the mass. ``at`` : its distance from the last joint; None: at the link's end.
    """

    mass: float = 0.0  # kg
    inertia: float = 0.0  # kg m^2
    at: float | None = None  # m

    def place(self, length: Array | float) -> Array:
        """Distance from the last joint along its link, m; ``length`` m of that link."""
        return np.asarray(length if self.at is None else np.full_like(np.asarray(length, dtype=float), self.at))

    def on_links(self, length: Array, first: int) -> tuple[Array, Array]:
        """The link that carries it, and where, if the leg's last link is the links from ``first`` on (one that bends).

        ``length`` (n, n_lane) m of all links. Returns (n, n_lane) 1 for the link that carries it, 0 for others, and
        (n_lane,) m from that link's joint.
        """
        shares, last = np.zeros(length.shape), length.shape[0] - 1
        if self.at is None or first == last:
            shares[last] = 1.0
            return shares, self.place(length[last])
        begins = np.cumsum(length[first:], axis=0) - length[first:]  # of each part, from the leg's last joint
        part = (begins[1:] <= max(self.at, 0.0)).sum(axis=0)
        lanes = np.arange(length.shape[1])
        shares[first + part, lanes] = 1.0
        return shares, self.at - begins[part, lanes]


@dataclass(frozen=True)
class Spring:
    """A linear torsion spring: torque on q is ``-rate * (q - sign * (free_angle - zero))``."""

    rate: float  # N m/rad
    free_angle: float  # rad, measured angle at which the spring is unloaded
    part: str | None = None  # the catalogue part that it represents


@dataclass(frozen=True)
class DamperCurve:
    """An odd torque-speed curve, linear between its points; beyond them see ``swing/damper_curves``.

    ``speed`` and ``torque``: (n_point,) rad/s and N m, strictly increasing speeds > 0; (0, 0) is implied.
    """

    speed: tuple[float, ...]
    torque: tuple[float, ...]

    @property
    def falls_at_end(self) -> bool:
        """Whether the last torque is less than the one before it."""
        return self.torque[-1] < (0.0, *self.torque)[-2]

    @property
    def beyond_words(self) -> str:
        """What it does beyond its last point."""
        return "keeps its last torque" if self.falls_at_end else "goes on along its last slope"


@dataclass(frozen=True)
class Damper:
    """A rotary damper: a linear ``rate`` or a ``curve``; never both."""

    rate: float | None = None  # N m s/rad
    curve: DamperCurve | None = None
    part: str | None = None


def turning_inertia(
    whole: Array | float,
    damping: Array | float,
    lag: Array | float,
    about_joint: Array | float,
) -> Array:
    """Kg m^2 that turn with a joint: the ``whole`` rotor and armature less a winding's lag, see ``servo.lightened``.

    The lag may take more than an unstated rotor has: then the link's own inertia ``about_joint`` is the less.
    """
    return np.maximum(lightened(whole, damping, lag), -MOST_LAGGED * about_joint)


@dataclass(frozen=True)
class Joint:
    """A hinge with its distal link.

    ``effects`` : name of the effect -> its parameters in SI, e.g. ``{"coulomb_friction": {"torque": 0.05}}``.
    """

    name: str
    link: Link
    zero: float = 0.0  # rad
    sign: int = 1
    range: tuple[float, float] | None = None  # rad, measured
    spring: Spring | None = None
    damper: Damper | None = None
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    armature: float = 0.0  # kg m^2, inertia that turns with the joint, in addition to the rotor of its ``drive``
    drive: Servo | TorqueDrive | None = None

    @property
    def rest(self) -> float:
        """Rotation q at which the spring is unloaded, rad; 0 without a spring."""
        return self.sign * (self.spring.free_angle - self.zero) if self.spring is not None else 0.0

    @property
    def with_rotor(self) -> float:
        """Inertia in kg m^2 that turns with the joint, its armature and the rotor of its drive, less a winding's lag.

        Less than 0 where the lag takes more than these have. A motor whose current is known has no lag: its torque is
        that of the current.
        """
        drive = self.drive
        damping = drive.motor.short_circuit_damping if isinstance(drive, Servo) and drive.motor is not None else 0.0
        return float(turning_inertia(self.with_whole_rotor, damping, self.lag, self.link.about_joint))

    @property
    def with_whole_rotor(self) -> float:
        """Inertia in kg m^2 that turns with the joint, its armature and the rotor of its drive."""
        motor = None if self.drive is None else self.drive.motor
        return self.armature + (0.0 if motor is None else motor.reflected_inertia)

    @property
    def lag(self) -> float:
        """Time constant in s of the winding whose torque the simulation computes; 0 without one."""
        return self.drive.lag if isinstance(self.drive, Servo) else 0.0

    @property
    def ends(self) -> tuple[float, float] | None:
        """Smallest and largest rotation q of the range, rad; None without a range."""
        if self.range is None:
            return None
        low, high = sorted(self.sign * (angle - self.zero) for angle in self.range)
        return low, high


@dataclass(frozen=True)
class Leg:
    """A chain of 1 to 6 links, proximal to distal.

    ``read_from`` : whole paths of the files that code read it from, which a result of it must not replace; empty if it
    was made in code, and of a project's, which knows its files. Equality leaves it out.
    """

    name: str
    joints: tuple[Joint, ...]
    gravity: float = 9.81  # m/s^2
    tilt: float = 0.0  # rad, rotation of the whole base, counter-clockwise positive
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # of the base
    read_from: tuple[str, ...] = field(default=(), compare=False, repr=False)

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
        """(n_joint,) rad, rotations q at which the springs are unloaded; 0 without a spring."""
        return np.array([joint.rest for joint in self.joints])

    @property
    def spring_rate(self) -> Array:
        """(n_joint,) N m/rad; 0 without a spring."""
        return np.array([joint.spring.rate if joint.spring is not None else 0.0 for joint in self.joints])

    @property
    def armature(self) -> Array:
        """(n_joint,) kg m^2, inertia that turns with each joint."""
        return np.array([joint.with_rotor for joint in self.joints])

    @property
    def total_length(self) -> float:
        """Sum of the link lengths, m."""
        return sum(joint.link.length for joint in self.joints)

    def to_rotation(self, measured: Array) -> Array:
        """Measured angles (..., n_joint) rad to rotations q (..., n_joint) rad."""
        return self.sign * (measured - self.zero)

    def to_measured(self, rotation: Array) -> Array:
        """Rotations q (..., n_joint) rad to measured angles (..., n_joint) rad."""
        return self.zero + self.sign * rotation

    def within_travel(self, rotation: Array) -> Array:
        """(n,) rad, the pose with each joint inside its range, if it has one."""
        found = np.array(rotation, dtype=float)
        for j, joint in enumerate(self.joints):
            if joint.ends is not None:
                found[j] = np.clip(found[j], *joint.ends)
        return found

    def rates_off_stops(self, rotation: Array, rate: Array) -> Array:
        """(n,) rad/s, without rates that lead a joint with stops (``joint_stop``) out of a range at whose end it is."""
        found = np.array(rate, dtype=float)
        for j, joint in enumerate(self.joints):
            if joint.ends is not None and "joint_stop" in joint.effects:
                low, high = joint.ends
                if rotation[j] <= low + AT_STOP:
                    found[j] = max(found[j], 0.0)
                elif rotation[j] >= high - AT_STOP:
                    found[j] = min(found[j], 0.0)
        return found

    def with_joints(self, **changes: Mapping[str, object]) -> Leg:
        """A copy with fields of the named joints replaced, ``leg.with_joints(knee={"spring": spring})``."""
        joints = [
            replace(joint, **changes[joint.name]) if joint.name in changes else joint  # type: ignore[arg-type]
            for joint in self.joints
        ]
        return replace(self, joints=tuple(joints))
