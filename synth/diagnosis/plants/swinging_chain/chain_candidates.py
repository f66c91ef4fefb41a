"""Candidates: an effect at a place in one of its shapes, in natural sizes of the leg's motion there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array, Mask
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import Key
from synth.diagnosis.plants.swinging_chain.idle_effects import torque_is_known
from synth.diagnosis.plants.swinging_chain.pieces import whole_recordings
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.drives.servo import Servo, TorqueDrive, fed_together
from synth.estimation.parameters import Parameter, Shape
from synth.pace import paces
from synth.swing.damper_curves import torque_at
from synth.swing.effect_directions import has_direction, turned_to_rotation
from synth.swing.effects import Effect, effect_named, registered
from synth.swing.effects.definition import Need
from synth.swing.leg_model import Damper, Leg
from synth.swing.mechanics import coefficients, outboard_inertia
from synth.swing.stated_effects import Place

LEAST_NATURAL_ANGLE = 0.02  # rad, about a degree: natural size of a joint that hardly moves
LEAST_WARMING_TIME = 15.0  # s, least length of a log that shows a winding warm: a fifth of its rise at the usual 60 s
# A mount sways at least so much faster than the slowest joint: a slower one would be seen. Without the limit it is a
# second pendulum with a state of its own in each trial, which imitates what the library lacks and wrong masses.
MOUNT_FREQUENCY_RATIO = 1.5
MOVING_SHARE = 0.1  # of its largest range in a trial, from which a joint's motion there counts for its pace
TIMES_THE_PACE = 2.0  # times the pace: the reciprocal of a sinusoid's angular frequency, see ``synth.pace``


@dataclass(frozen=True)
class NaturalSizes:
    """A joint's natural sizes from its motion, so that priors scale with the size of the leg.

    ``angle`` (n,) rad and ``speed`` (n,) rad/s, amplitudes; ``torque`` (n,) N m, see ``_natural_torques``; ``force`` N,
    the leg's weight, or the driving force without gravity; ``length`` (n,) m of the link; ``middle`` (n,) rad of the
    motion's range, ``half`` (n,) its half width, ``settled`` (n,) the spring's deflection at the end of the trials
    (median), all in the sense of q; ``time`` (n,) s, the reciprocal of the joint's highest frequency in the trials: a
    slow hip may be read late by a whole period of a fast ankle; ``damping`` (n,) N m s/rad of the designed dampers;
    ``mass`` kg of the whole leg; ``winding`` ohm, of the windings that one source feeds, in parallel; ``slow`` 1/s, the
    lowest natural frequency of a joint.
    """

    angle: Array
    speed: Array
    torque: Array
    force: float
    length: Array
    middle: Array
    half: Array
    settled: Array
    time: Array
    damping: Array
    mass: float
    winding: float = 1.0
    slow: float = 0.0

    def of(self, unit: str, joint: int) -> float:
        """Natural size of a unit at a joint; 1 for units that have none."""
        angle, speed, torque = self.angle[joint], self.speed[joint], self.torque[joint]
        sizes = {
            "rad": angle,
            "rad/s": speed,
            "s": min(angle / speed, self.time[joint]),
            "kg": self.mass,
            "N*m": torque,
            "N*m/rad": torque / angle,
            "N*m*s/rad": max(torque / speed, self.damping[joint]),
            "N*m*s^2/rad^2": torque / speed**2,
            "m": self.length[joint],
            "N": self.force,
            "1/rad": 1.0 / angle,
            "s/rad": 1.0 / speed,
            "kg*m^2": torque * angle / speed**2,
            "N/m": torque / angle / self.length[joint] ** 2,
            "ohm": self.winding,
        }
        return float(sizes.get(unit, 1.0))


def natural_sizes_of(leg: Leg, trials: Sequence[AngleTrial]) -> NaturalSizes:
    """Natural sizes of each joint from the trials in which it is free; of cut recordings from the ``wholes``.

    A piece of a fifth of a second shows a period that is mostly its own length, and the limit of a delay, two of these
    times, would be that of the piece.
    """
    trials, n = whole_recordings(trials), len(leg.joints)
    low, high, speed, known = np.full(n, np.inf), np.full(n, -np.inf), np.zeros(n), np.zeros(n)
    for trial in trials:
        smoothed, driven = trial.recording.smoothed, trial.recording.known_force(trial.recording.leg or leg)
        for j in trial.free:
            low[j] = min(low[j], float(smoothed.angle[:, j].min()))
            high[j] = max(high[j], float(smoothed.angle[:, j].max()))
            # 98 %: not a single outlier.
            speed[j] = max(speed[j], float(np.percentile(np.abs(smoothed.rate[:, j]), 98)))
            known[j] = max(known[j], 0.0 if driven is None else float(np.percentile(np.abs(driven[:, j]), 98)))
    ends = [[float(t.recording.smoothed.angle[-1, j]) for t in trials if j in t.free] for j in range(n)]
    moved = np.isfinite(low)
    low, high = np.where(moved, low, -0.1), np.where(moved, high, 0.1)
    longest = max(float(trial.time[-1]) for trial in trials)
    speed = np.maximum(speed, LEAST_NATURAL_ANGLE / longest)
    # Rad: a joint that hardly moves.
    rest, half = leg.rest, np.maximum(0.5 * (high - low), 0.01)
    angle = np.maximum(np.maximum(np.abs(low - rest), np.abs(high - rest)), LEAST_NATURAL_ANGLE)
    free = {j for trial in trials for j in trial.free}
    angle = np.where(_unsprung(leg, free), half, angle)
    torque = _natural_torques(leg, angle, half, speed, known)
    mass = sum(j.link.mass for j in leg.joints)
    weight = leg.gravity * mass
    length = np.array([j.link.length for j in leg.joints])
    force = weight if weight > 0.0 else float(np.max(torque / length))
    damping = np.array([_damper_rate(joint.damper, float(w)) for joint, w in zip(leg.joints, speed, strict=True)])
    middle = 0.5 * (low + high)
    settled = np.array([np.median(each) if each else at for each, at in zip(ends, rest, strict=True)]) - rest
    time, winding = TIMES_THE_PACE * _own_paces(trials, n), _parallel_resistance(leg)
    sizes = angle, speed, torque, force, length, middle, half, settled, time, damping, mass, winding
    return NaturalSizes(*sizes, slow=_slowest_frequency(leg, speed / half))


def _own_paces(trials: Sequence[AngleTrial], n: int) -> Array:
    """(n,) s, the least pace of each joint over the trials in which it moves; of the fastest joint if it never does.

    What a joint shows that stands still is the sensor's or the torque's jitter, whose pace is the sampling's and not
    the joint's: the limit of a delay, which is counted in paces, would then be far too short.
    """
    found = np.full(n, np.inf)
    widths = np.array([np.ptp(trial.recording.smoothed.angle, axis=0) for trial in trials])
    for trial, width in zip(trials, widths, strict=True):
        smoothed = trial.recording.smoothed
        own = paces(float(smoothed.time[1] - smoothed.time[0]), smoothed.angle)
        moves = [j for j in trial.free if width[j] >= MOVING_SHARE * widths[:, j].max()]
        found[moves] = np.fmin(found[moves], own[moves])
    return np.where(np.isfinite(found), found, min(trial.recording.smoothed.pace for trial in trials))


def _slowest_frequency(leg: Leg, swung: Array) -> float:
    """1/s, lowest natural frequency of a joint of the straight hanging leg; without stiffness as it ``swung`` (n,)."""
    stiffness = leg.spring_rate + np.cumsum(coefficients(leg).gravity[::-1])[::-1]
    return float(np.min(np.where(stiffness > 0.0, np.sqrt(np.abs(stiffness) / outboard_inertia(leg)), swung)))


def _parallel_resistance(leg: Leg) -> float:
    """Ohm, of the windings that one source feeds; 1 without."""
    drives = [joint.drive for joint in leg.joints]
    motors = [drive.motor for j, drive in enumerate(drives) if drive is not None and j in fed_together(drives)]
    conductance = sum(1.0 / motor.resistance for motor in motors if motor is not None)
    return 1.0 / conductance if conductance else 1.0


def _unsprung(leg: Leg, free: AbstractSet[int]) -> Mask:
    """(n,) True for a free joint without spring or gravity, which has no reference for its deflection."""
    hanging = coefficients(leg).weight
    return np.array(
        [j in free and rate <= 0.0 and not hanging[j:].any() for j, rate in enumerate(leg.spring_rate.tolist())]
    )


def _natural_torques(leg: Leg, angle: Array, half: Array, speed: Array, known: Array) -> Array:
    """(n,) N m, natural torque of each joint: the largest of its driving torques.

    Spring and gravity at its deflection, gravity at most that of a horizontal link; the ``known`` torque; the outboard
    inertia times the acceleration ``speed^2 / half``. For a joint moved by its spring these two are equal,
    so half of the inertia's is used: the spring's is more reliable, because it needs no speed.
    """
    found = coefficients(leg)
    hanging = np.cumsum(found.gravity[::-1])[::-1]  # gravity's contribution to the stiffness
    static = leg.spring_rate * angle + hanging * np.minimum(angle, 0.5 * np.pi)
    return np.asarray(np.maximum(np.maximum(static, known), 0.5 * outboard_inertia(leg) * speed**2 / half))


def _damper_rate(damper: Damper | None, speed: float) -> float:
    """N m s/rad of a damper at a speed, rad/s."""
    if damper is None:
        return 0.0
    if damper.curve is not None:
        return float(torque_at(damper.curve, np.array([speed]))[0]) / speed
    return damper.rate or 0.0


@dataclass(frozen=True)
class Candidate(ShapedEffect):
    """One effect at one joint (0 for the base) in one shape.

    ``legs`` : of all trials. ``replaced`` : stated effects of the same kin at its joint, of which it takes the place.
    """

    effect: Effect
    joint: int
    scales: NaturalSizes
    leg: Leg
    legs: TrialLegs
    replaced: tuple[str, ...] = ()

    @property
    def key(self) -> Key:
        """Effect and place, as named in files."""
        return self.effect.name, "base" if self.effect.where == "base" else self.leg.joints[self.joint].name

    @property
    def replaced_keys(self) -> tuple[Key, ...]:
        """Effect and place of the stated effects of the same kin of which it takes the place."""
        return tuple((name, self.key[1]) for name in self.replaced)

    @property
    def links(self) -> int:
        """Number of links it adds: one per compliant direction of a structure."""
        return _added_links(self.effect, self.shape)

    @property
    def replaced_links(self) -> int:
        """Number of links of the stated structure whose place it takes."""
        return self.legs.replaced_links(self.place)

    @property
    def nearly_linear(self) -> bool:
        """The change of the leg's numbers or the readings."""
        return self.effect.way in ("leg", "reading")

    @property
    def place(self) -> Place:
        """The effect's name and its joint, as of a stated effect."""
        return self.effect.name, self.joint

    @property
    def places(self) -> frozenset[Place]:
        """Its place, and those of the stated effects of the same kin of which it takes the place."""
        return frozenset({self.place, *((name, self.joint) for name in self.replaced)})

    @property
    def part(self) -> str:
        """The spring or damper that a design would replace with the effect; empty for one of the joint or base."""
        return "" if self.effect.belongs_to == "joint" else self.effect.belongs_to

    @property
    def is_compliance(self) -> bool:
        """A compliant structure."""
        return self.effect.way == "structure"

    def stands_beside(self, others: Sequence[ShapedEffect]) -> bool:
        """Each place has at most one structure and one dry friction; the engine limits the number of links."""
        return self._leave_room((*others, self)) and all(compatible(other, self) for other in others)

    @property
    def has_room(self) -> bool:
        """Whether the engine can simulate it alone."""
        return self._leave_room((self,))

    def _leave_room(self, causes: Sequence[ShapedEffect]) -> bool:
        """Whether the engine has the links that these causes add to the leg of every trial."""
        placed = [(each.effect.name, each.joint, each.links) for each in causes if isinstance(each, Candidate)]
        return self.legs.leave_room([((name, joint), number) for name, joint, number in placed])

    def natural_size(self, parameter: Parameter) -> float:
        """The natural size from the joint's motion, see ``NaturalSizes``."""
        return min(self.scales.of(parameter.unit, self.joint), parameter.largest) if parameter.natural else 1.0

    def in_units(self, parameter: Parameter, value: Array) -> Array:
        """Natural values (n_lane,) of a free parameter in SI and measured sense."""
        if not parameter.anchor:
            return super().in_units(parameter, value)
        joint = self.leg.joints[self.joint]
        if parameter.anchor == "settled":
            return np.asarray(joint.sign * self.scales.settled[self.joint] + value)
        middle = joint.zero + joint.sign * self.scales.middle[self.joint]
        return np.asarray(middle + value * self.scales.half[self.joint])

    def values(self, x: Array) -> Array:
        """The values as for any effect, kept plausible for this leg; of one that is absent those that switch it off."""
        if self.is_absent:
            return np.tile([[parameter.off] for parameter in self.effect.parameters], (1, x.shape[1]))
        found = super().values(x)
        if not self.effect.bounds:
            return found
        bounded = self.effect.function(self.effect.bounds)
        return np.asarray(bounded(self.leg, self.joint, MOUNT_FREQUENCY_RATIO * self.scales.slow, found))

    def named(self, x: Array) -> dict[str, float]:
        """Parameters to report; of an absent effect its sizes, which are 0: a stiffness has none then."""
        if not self.is_absent:
            return super().named(x)
        sizes = [p for p in self.effect.parameters if p.name in self.effect.strengths and p.prior is not None]
        return {p.name: p.off for p in sizes if p.prior is not None and not (p.prior.log or p.prior.inverse)}

    def in_rotation(self, x: Array) -> Array:
        """Like ``values``, converted to the sense of q where direction matters."""
        values = self.values(x)
        if self.is_absent or not has_direction(self.effect):
            return values
        joint = self.leg.joints[self.joint]
        turned = [turned_to_rotation(self.effect, joint.sign, joint.zero, lane) for lane in values.T.tolist()]
        return np.array(turned).T


def compatible(first: ShapedEffect, second: ShapedEffect) -> bool:
    """No cause is counted twice; each place has at most one structure and one dry friction."""
    if first.key == second.key:
        return False
    if first.key[1] != second.key[1] or not (isinstance(first, Candidate) and isinstance(second, Candidate)):
        return True
    both = first.effect.way == second.effect.way == "structure"
    return not both and not (first.effect.kin and first.effect.kin == second.effect.kin)


def _has_one_of(needs: Sequence[str], there: AbstractSet[str]) -> bool:
    """Whether one of the required properties is present, or none is required."""
    return not needs or not there.isdisjoint(needs)


def _properties_of_joint(leg: Leg, joint: int, trials: Sequence[AngleTrial]) -> AbstractSet[str]:
    """What a joint has on which an effect can act: spring, damper, armature, known torque, servo, motor, supply."""
    spring, damper = leg.joints[joint].spring, leg.joints[joint].damper
    found: set[Need] = {"spring" if spring is not None and spring.rate > 0.0 else "no spring"}
    if damper is not None and (damper.curve is not None or (damper.rate or 0.0) > 0.0):
        found.add("damper")
    found.add("armature" if leg.joints[joint].armature > 0.0 else "no armature")
    if torque_is_known([trial.recording for trial in trials], joint):
        found.add("torque")
    drive = leg.joints[joint].drive
    moved = drive is not None or "torque" in found
    if moved and leg.joints[joint].with_whole_rotor > 0.0 and found.isdisjoint({"spring", "damper"}):
        found.add("driven rotor")
    found |= {"recorded current"} if isinstance(drive, TorqueDrive) and drive.motor and "torque" in found else set()
    if isinstance(drive, Servo):
        found |= {"servo"} if drive.gain else set()
        found |= {"held commands"} if drive.gain and not drive.linear_commands else set()
        found |= {"motor"} if drive.motor is not None else set()
        longest = max((float(trial.time[-1]) for trial in trials if joint in trial.free), default=0.0)
        found |= {"time to warm"} if drive.motor is not None and longest >= LEAST_WARMING_TIME else set()
        signals = [trial.recording.signals for trial in trials if joint in trial.free]
        measured = any(each is not None and np.ptp(each.supply[:, joint]) > 0.0 for each in signals)
        if drive.motor is not None and not measured:
            # A joint of a common source has leads of its own too.
            together = joint in fed_together([each.drive for each in leg.joints])
            found |= {"stated supply", "shared supply"} if together else {"stated supply"}
    return found


def _properties_of_leg(leg: Leg, trials: Sequence[AngleTrial]) -> AbstractSet[str]:
    """What a leg has on which an effect of the base can act, of what ``_properties_of_joint`` finds at a joint."""
    free = {j for trial in trials for j in trial.free}
    return {"shared supply"} if any("shared supply" in _properties_of_joint(leg, j, trials) for j in free) else set()


def candidates(
    leg: Leg, trials: Sequence[AngleTrial], found: NaturalSizes, legs: TrialLegs | None = None
) -> list[Candidate]:
    """Every effect at every place where it could act and be visible, in every shape that can be simulated.

    ``legs`` : of all trials that are simulated; None: of these.
    """
    known = legs or TrialLegs.of(leg, [trial.recording.leg for trial in trials])
    made = (
        Candidate(effect, shape, joint, found, leg, known) for effect, shape, joint in _possible(leg, trials, known)
    )
    return [candidate for candidate in made if candidate.has_room]


def causes_without_room(leg: Leg, trials: Sequence[AngleTrial], legs: TrialLegs) -> dict[str, list[str]]:
    """Effects that could act and be visible, and their places where they cannot be simulated in any shape."""
    room: dict[Place, bool] = {}
    found: dict[str, list[str]] = {}
    for effect, shape, joint in _possible(leg, trials, legs):
        place = effect.name, joint
        room[place] = legs.leave_room([(place, _added_links(effect, shape))]) or room.get(place, False)
    for name, joint in (place for place, fits in room.items() if not fits):
        at_base = effect_named(name).where == "base"
        found.setdefault(name, []).append("base" if at_base else leg.joint_names[joint])
    return found


def _possible(leg: Leg, trials: Sequence[AngleTrial], legs: TrialLegs) -> Iterator[tuple[Effect, Shape, int]]:
    """Every effect, its shape and its place where it could act and be visible."""
    free = sorted({j for trial in trials for j in trial.free})
    kept = [legs.own_places(trial.recording.leg or leg) for trial in trials]
    for effect in registered():
        # A link's mass is visible where it moves: at a free joint or outboard of one.
        first = min(free, default=0) if effect.way == "leg" else 0
        places = range(first, len(leg.joints)) if effect.shows_locked else free
        for joint in [0] if effect.where == "base" else places:
            if all((effect.name, joint) in own for own in kept):
                continue  # every trial's leg has one of its own, so a common one acts nowhere
            there = (
                _properties_of_leg(leg, trials) if effect.where == "base" else _properties_of_joint(leg, joint, trials)
            )
            for shape in effect.shapes:
                if _has_one_of(effect.needs, there) and _has_one_of(shape.needs, there):
                    yield effect, shape, joint


def _added_links(effect: Effect, shape: Shape) -> int:
    """Number of links that an effect adds: one per compliant direction of a structure."""
    return len({*shape.free, *shape.held} & {*effect.strengths}) if effect.way == "structure" else 0
