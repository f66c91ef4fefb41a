"""Legs as columns: the parameters of many variants of one leg, from which the lanes of the compiled chain are made.

A diagnosis runs hundreds of legs that differ in a few parameters. To write each separately would take longer than to
simulate it, so each quantity is one array with one column per leg.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from synth.arrays import Array, Mask
from synth.drives.servo import INTEGRAL_LIMIT, UNLIMITED, Servo, TorqueDrive, delayed, fed_together
from synth.errors import UserError
from synth.swing.damper_curves import compiled_rows
from synth.swing.effect_directions import in_rotation
from synth.swing.effects import Effect, effect_named, registered
from synth.swing.lane_layout import CONTROLLED, CURVE_POINTS, DRIVE, LANES, MOST_LINKS, SERVO, Layout
from synth.swing.leg_model import Leg, Tip, turning_inertia
from synth.swing.readings import control_readings
from synth.swing.stated_effects import stated_effects

INITIAL_ACCELERATION = 0.3  # of g: the load of a compliant link may accelerate so much when a recording begins
# s between two commands: a limited command that reaches its goal in so short a time counts as a line of the same mean
# and first moment; at 200 Hz a joint is then exact to 2e-5 rad (tests/drives/test_command_rate.py).
SLEW_SHORT = 0.012
TOO_MANY_LINKS = (
    f"the leg's joints and the links that its effects add are more than {MOST_LINKS}, the most that are simulated: "
    "state fewer of base_compliance, gear_play and link_flexibility"
)
_PER_LINK = ("length", "mass", "com", "com_across", "inertia", "spring_rate", "rest", "damper_rate", "armature", "lag")


@dataclass
class LegLanes:
    """Columns of legs; every array has ``n_lane`` columns and may be changed in place.

    ``length``, ``com``, ``com_across`` (n, n_lane) m, ``mass`` kg, ``inertia`` kg m^2 about the com, ``spring_rate`` N
    m/rad, ``rest`` rad (rotation at which the spring is unloaded), ``damper_rate`` N m s/rad, ``armature`` kg m^2
    (turns with the joint, its rotor included); ``tilt`` (n_lane,) rad; ``source`` (n_lane,) ohm of the source that
    feeds several servos; ``drive`` (3, n, n_lane) errors of a known torque on q: gain (share), offset N m, delay s;
    ``servo`` (17, n, n_lane) parameters of the servos in the order of ``SERVO``, 0 without a servo, of their torque
    limits that by the current; ``torque_limit`` (n, n_lane) N m, that which no motor constant changes; ``winding`` (n,
    n_lane) stated resistance of a winding over that with effects; ``lag`` (n, n_lane) s of a winding, which is not yet
    in ``servo`` and ``armature`` but in ``servo_numbers`` and ``own_inertia``: so it follows what changes a motor's
    constants. ``own_emf`` (n,) True for a motor whose back-EMF constant is stated beside its torque constant.
    ``weightless`` (n,) links on which gravity does no work (a sliding base). ``read_beyond`` (n, n_lane) 1 where the
    encoder of the recording sits behind a gear's play: it reads the joint's rotation and that of the next hinge; else
    0. ``controlled`` (3, n, n_lane) what a servo controls in place of its joint's rotation, see ``CONTROLLED``.
    ``torques`` : name of a torque effect -> (n_parameter, n, n_lane) in the sense of q. ``curves`` : clamp speeds and
    slopes (2, 12) of each joint, or None.
    """

    length: Array
    mass: Array
    com: Array
    com_across: Array
    inertia: Array
    spring_rate: Array
    rest: Array
    damper_rate: Array
    tilt: Array
    gravity: float
    weightless: Array
    curves: list[tuple[Array, Array] | None]
    armature: Array
    drive: Array
    servo: Array
    torque_limit: Array
    winding: Array
    lag: Array
    own_emf: Mask
    torques: dict[str, Array] = field(default_factory=dict)
    own: tuple[int, ...] = ()  # index in the chain of each joint of the leg
    source: Array = field(default_factory=lambda: np.zeros(1))
    read_beyond: Array = field(default_factory=lambda: np.zeros((1, 1)))
    controlled: Array = field(default_factory=lambda: np.zeros((len(CONTROLLED), 1, 1)))
    newest: int = -1  # index of the link that was inserted last, before others of the same effect

    @property
    def n(self) -> int:
        """Number of links."""
        return int(self.length.shape[0])

    @property
    def n_lane(self) -> int:
        """Number of legs."""
        return int(self.length.shape[1])

    @classmethod
    def of(cls, leg: Leg, n_lane: int = 1) -> LegLanes:
        """The same leg in every column with its torque effects, rigid links and a fixed base.

        Raises
        ------
        ValueError : the leg has an effect that only changes one of its numbers; change that number instead.
        """
        joints = leg.joints
        for name in {*leg.effects, *(name for joint in joints for name in joint.effects)}:
            if effect_named(name).way == "leg":
                raise ValueError(f"{name} changes numbers of the leg: change those, not its effects")

        def column(values: Sequence[float] | Array) -> Array:
            return np.repeat(np.array(values, dtype=float)[:, None], n_lane, axis=1)

        made = cls(
            length=column([j.link.length for j in joints]),
            mass=column([j.link.mass for j in joints]),
            com=column([j.link.com for j in joints]),
            com_across=column([j.link.com_across for j in joints]),
            inertia=column([j.link.inertia for j in joints]),
            spring_rate=column(leg.spring_rate),
            rest=column(leg.rest),
            damper_rate=column([(j.damper.rate or 0.0) if j.damper else 0.0 for j in joints]),
            tilt=np.full(n_lane, leg.tilt),
            gravity=leg.gravity,
            weightless=np.zeros(len(joints)),
            curves=[compiled_rows(j.damper.curve) if j.damper and j.damper.curve else None for j in joints],
            armature=column([joint.with_whole_rotor for joint in joints]),
            drive=np.zeros((len(DRIVE), len(joints), n_lane)),
            servo=_servos(leg, n_lane),
            torque_limit=column([_stated_limit(joint.drive) for joint in joints]),
            winding=np.ones((len(joints), n_lane)),
            lag=column([joint.lag for joint in joints]),
            own_emf=np.array([_own_emf(joint.drive) for joint in joints]),
            own=tuple(range(len(joints))),
            source=np.zeros(n_lane),
            read_beyond=np.zeros((len(joints), n_lane)),
            controlled=np.zeros((len(CONTROLLED), len(joints), n_lane)),
        )
        for index, joint in enumerate(joints):
            for name, given in joint.effects.items():
                effect = effect_named(name)
                if effect.way == "torque":
                    made.put(effect, index, in_rotation(effect, joint.sign, joint.zero, given))
                elif effect.way == "drive":
                    effect.function()(made, index, joint.sign, *made.columns(effect, given))
        for name, given in leg.effects.items():
            effect = effect_named(name)
            if effect.way == "drive":
                effect.function()(made, 0, 1, *made.columns(effect, given))
        return made

    def columns(self, effect: Effect, given: Mapping[str, float]) -> list[Array]:
        """Each parameter of an effect (n_lane,), with defaults."""
        return [np.full(self.n_lane, given.get(p.name, effect.defaults[p.name])) for p in effect.parameters]

    def repeated(self, n_lane: int) -> LegLanes:
        """The first leg in ``n_lane`` columns; a copy."""

        def wide(values: Array) -> Array:
            return np.repeat(values[..., :1], n_lane, axis=-1)

        links: dict[str, Any] = {name: wide(getattr(self, name)) for name in _PER_LINK}
        return replace(
            self,
            **links,
            torques={name: wide(values) for name, values in self.torques.items()},
            tilt=wide(self.tilt),
            source=wide(self.source),
            read_beyond=wide(self.read_beyond),
            controlled=wide(self.controlled),
            weightless=self.weightless.copy(),
            drive=wide(self.drive),
            servo=wide(self.servo),
            torque_limit=wide(self.torque_limit),
            winding=wide(self.winding),
            curves=list(self.curves),
        )

    @classmethod
    def whole(cls, leg: Leg, n_lane: int = 1) -> LegLanes:
        """As ``of``, with the additional links of a moving base and of bending links."""
        return cls.held(leg, np.zeros((len(leg.joints), n_lane)))[0]

    @classmethod
    def held(cls, leg: Leg, rotation: Array, locked: tuple[int, ...] = ()) -> tuple[LegLanes, Array]:
        """As ``whole``, and rotations (n_link, n_lane) rad of the leg held at ``rotation`` (n, n_lane) rad.

        The additional links are deflected as the held leg deflects them. ``locked`` : the leg's locked joints.
        """
        n_lane = rotation.shape[1]
        legs, full = cls.of(leg, n_lane), np.array(rotation, dtype=float)
        errors = stated_effects(leg, "reading")
        control_readings(
            legs.controlled, leg, [(each, legs.columns(each.effect, each.given), slice(None)) for each in errors]
        )
        for stated in stated_effects(leg, "structure"):
            at = legs.own[stated.joint]
            legs = stated.effect.function()(legs, at, *legs.columns(stated.effect, stated.given))
            full = legs.started(stated.effect, stated.joint, full, locked)
        return legs, full

    def started(self, effect: Effect, joint: int, rotation: Array, locked: tuple[int, ...]) -> Array:
        """Rotations (n_link, n_lane) rad with the initial ones of the links that a structure effect just inserted.

        The lock of a locked joint carries its spring's torque, which then bends nothing.
        """
        full = np.insert(rotation, [self.newest] * (self.n - len(rotation)), 0.0, axis=0)
        at, count = self.own[joint], self.n - len(rotation)
        if joint not in locked or effect.parts_drive:
            full[self.newest : self.newest + count] = effect.function("start")(self, at, full)
        if self.newest == at + 1:  # the given rotation is what the encoder reads
            full[at] -= self.read_beyond[at] * full[self.newest]
        return full

    def as_read(self, motion: Array) -> Array:
        """(n_time, n, n_lane) of the leg's own joints as encoders without error read them.

        ``motion`` (n_time, n_link, n_lane) rotations or rates of all links.
        """
        own = list(self.own)
        found: Array = motion[:, own] if self.n > len(own) else motion[:, : self.n]
        for j in np.flatnonzero(self.read_beyond[own].any(axis=1)).tolist():
            found[:, j] += self.read_beyond[own[j]] * motion[:, own[j] + 1]
        return found

    def initial_deviation(self, effect: Effect, link: int, joint: int, rotation: Array) -> tuple[Array, Array]:
        """Largest initial deviation (n_lane,) rad and velocity rad/s of an added link from its held position.

        In a recording that begins after the release, the mount or the bending link already moves. Its deviation is the
        deflection by ``INITIAL_ACCELERATION`` of the carried weight and by the joint's spring. Its velocity follows
        from its natural frequency. An effect whose links have no spring has a function ``deviation`` of its own.
        ``link``, ``joint`` : indices in this chain.
        """
        ends = np.cumsum(self.length[link:], axis=0)
        reach = ends - self.length[link:] + self.com[link:]
        across = self.com_across[link:]
        moment = np.hypot(*((self.mass[link:] * lever).sum(axis=0) for lever in (reach, across)))
        moving = (self.inertia[link:] + self.mass[link:] * (reach**2 + across**2)).sum(axis=0)
        if effect.deviation:
            far, fast = effect.function(effect.deviation)(
                self, link, INITIAL_ACCELERATION * self.gravity * moment / moving
            )
            return far, fast
        spring = np.abs(self.spring_rate[joint] * (rotation[joint] - self.rest[joint]))
        far = (INITIAL_ACCELERATION * self.gravity * moment + spring) / self.spring_rate[link]
        return far, far * np.sqrt(self.spring_rate[link] / moving)

    def put(self, effect: Effect, joint: int, values: Array | list[float]) -> None:
        """Set a torque effect at one joint: parameters (n_parameter,) or (n_parameter, n_lane) in the sense of q."""
        if effect.name not in self.torques:
            off = np.array([parameter.off for parameter in effect.parameters])
            self.torques[effect.name] = np.tile(off[:, None, None], (1, self.n, self.n_lane))
        value = np.asarray(values, dtype=float)
        self.torques[effect.name][:, joint] = value if value.ndim == 2 else value[:, None]

    def with_link(self, before: int, **values: Array | float) -> LegLanes:
        """A copy with a link inserted before link ``before``; quantities are given by name, others are zero.

        Raises
        ------
        UserError : the chain has ``MOST_LINKS`` already.
        """
        if self.n >= MOST_LINKS:
            raise UserError(TOO_MANY_LINKS)
        changed = {}
        for name in _PER_LINK:
            row = np.broadcast_to(np.asarray(values.get(name, 0.0), dtype=float), (self.n_lane,))
            changed[name] = np.insert(getattr(self, name), before, row, axis=0)
        torques = {}
        for effect in registered():
            if effect.name in self.torques:
                off = np.array([parameter.off for parameter in effect.parameters])[:, None]
                torques[effect.name] = np.insert(self.torques[effect.name], before, off, axis=1)
        weightless = np.insert(self.weightless, before, float(np.mean(values.get("weightless", 0.0))))
        curves = [*self.curves[:before], None, *self.curves[before:]]
        own = tuple(i + (i >= before) for i in self.own)
        return replace(
            self,
            **changed,
            weightless=weightless,
            curves=curves,
            torques=torques,
            drive=np.insert(self.drive, before, 0.0, axis=1),
            servo=np.insert(self.servo, before, 0.0, axis=1),
            torque_limit=np.insert(self.torque_limit, before, UNLIMITED, axis=0),
            winding=np.insert(self.winding, before, 1.0, axis=0),
            read_beyond=np.insert(self.read_beyond, before, 0.0, axis=0),
            controlled=np.insert(self.controlled, before, 0.0, axis=1),
            own_emf=np.insert(self.own_emf, before, values=False),
            own=own,
            newest=before,
            tilt=self.tilt.copy(),
            source=self.source.copy(),
        )

    def servo_numbers(self) -> Array:
        """(17, n, n_lane) ``servo`` with its windings' lag, and the lower one of both torque limits."""
        numbers = delayed(self.servo, self.lag)
        limit = numbers[SERVO.index("servo_torque_limit")]
        np.minimum(limit, self.torque_limit, out=limit)
        return numbers

    @property
    def own_inertia(self) -> Array:
        """(n, n_lane) kg m^2 that turn with each joint: ``armature`` less what its winding's lag takes."""
        braking = self.servo[SERVO.index("servo_back_emf")]
        return turning_inertia(self.armature, braking, self.lag, self.about_joint)

    @property
    def about_joint(self) -> Array:
        """(n, n_lane) kg m^2, inertia of each link alone about its proximal joint."""
        return self.inertia + self.mass * (self.com**2 + self.com_across**2)

    def write(self, layout: Layout, locked: tuple[int, ...], tip: Tip, tilt: float, off: Array) -> Array:
        """(n_row, n_lane) the chain's lanes, with state rows zero.

        ``locked`` : indices in the chain. ``off`` : (n_row,) a lane whose effects are off. Coefficients are those of
        ``mechanics.coefficients``.

        Raises
        ------
        ValueError : an effect is not in the compiled chain.
        """
        n = self.n
        lanes = np.repeat(off[:, None], self.n_lane, axis=1)
        self._write_masses(lanes, layout, tip)
        lanes[layout.row("tilt")] = self.tilt + tilt
        lanes[layout.row("weight")] = self.gravity
        lanes[layout.row("source")] = self.source
        free = np.ones(n)
        free[list(locked)] = 0.0
        lanes[layout.rows("free")] = free[:, None]
        lanes[layout.rows("own_inertia")] = np.where(free[:, None] > 0.0, self.own_inertia, 1.0)
        if self.drive.any():
            for block, wrong in zip(DRIVE, self.drive, strict=True):
                lanes[layout.rows(block)] = wrong
        if self.servo.any():
            for block, numbers in zip(SERVO, self.servo_numbers(), strict=True):
                lanes[layout.rows(block)] = numbers
            lanes[layout.rows("slew_short")] = SLEW_SHORT
            for block, seen in zip(CONTROLLED, self.controlled, strict=True):
                lanes[layout.rows(block)] = seen
        for block, values in (
            ("spring_rate", self.spring_rate), ("rest", self.rest), ("damper_rate", self.damper_rate),
            ("length", self.length),
        ):  # fmt: skip
            lanes[layout.rows(block)] = values
        for j, curve in enumerate(self.curves):
            if curve is not None:
                rows = slice(j * CURVE_POINTS, (j + 1) * CURVE_POINTS)
                lanes[layout.rows("curve_speed")][rows] = curve[0][:, None]
                lanes[layout.rows("curve_slope")][rows] = curve[1][:, None]
        if not self.torques.keys() <= {law.name for law in layout.laws}:
            raise KeyError(
                f"not in the compiled chain: {sorted(self.torques.keys() - {law.name for law in layout.laws})}"
            )
        for name, given in self.torques.items():
            for p, values in enumerate(given):
                lanes[layout.parameter_rows(name, p)] = values
        return lanes

    def _write_masses(self, lanes: Array, layout: Layout, tip: Tip) -> None:
        """Write the coefficients of inertia and gravity, see ``write``."""
        tipped, at = tip.on_links(self.length, self.own[-1])
        carried = np.cumsum((self.mass + tip.mass * tipped)[::-1], axis=0)[::-1]
        outboard = np.concatenate([carried[1:], np.zeros((1, self.n_lane))])  # acts at the link's end
        moment = self.mass * self.com + outboard * self.length + tip.mass * tipped * at
        across, about_joint = self.mass * self.com_across, self.about_joint
        for i in range(self.n):
            own = about_joint[i] + outboard[i] * self.length[i] ** 2
            lanes[layout.inertia_row(i, i)] = own + tipped[i] * (tip.mass * at**2 + tip.inertia)
            for j in range(i + 1, self.n):
                lanes[layout.inertia_row(i, j)] = self.length[i] * moment[j]
                lanes[layout.across_row(i, j)] = self.length[i] * across[j]
        weight = self.gravity * (1.0 - self.weightless[:, None])
        lanes[layout.rows("gravity")], lanes[layout.rows("gravity_across")] = weight * moment, weight * across
        for block, values in (("carried_mass", carried), ("first_moment", moment), ("moment_across", across)):
            lanes[layout.rows(block)] = values


def _servos(leg: Leg, n_lane: int) -> Array:
    """(17, n, n_lane) parameters of each joint's servo in the order of ``SERVO`` without its lag, 0 without a servo."""
    numbers = np.zeros((len(SERVO), len(leg.joints), n_lane))
    shared = fed_together([joint.drive for joint in leg.joints])
    for index, joint in enumerate(leg.joints):
        if isinstance(joint.drive, Servo):
            numbers[:, index] = np.array(replace(joint.drive, torque_limit=np.inf).without_lag)[:, None]
            numbers[INTEGRAL_LIMIT, index] = joint.drive.without_lag[INTEGRAL_LIMIT]  # that by the torque's limit too
            if index not in shared:
                numbers[SERVO.index("servo_conductance"), index] = 0.0
    return numbers


def _stated_limit(drive: Servo | TorqueDrive | None) -> float:
    """N m, the limit that a drive states as a torque."""
    return min(drive.torque_limit, UNLIMITED) if isinstance(drive, Servo) else UNLIMITED


def _own_emf(drive: Servo | TorqueDrive | None) -> bool:
    """Whether a motor's back-EMF constant is stated by itself."""
    return drive is not None and drive.motor is not None and drive.motor.back_emf_constant is not None


assert LANES >= MOST_LINKS
