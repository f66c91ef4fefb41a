"""What to measure next: the static point that determines a spring rate left open by the trials.

The trials' information on the common unknowns follows from the sensitivities. A static point adds one row
(``static_points.Balance``), so its effect can be predicted: the joint's angle is the one at which
the spring rate's variance falls most (a c-optimal design, Pukelsheim, *Optimal Design of Experiments*, 2006, ch. 2),
and the torque's error the largest that still reaches the goal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, Estimate
from synth.fit.known import Known, half_width
from synth.fit.recordings import Recording
from synth.fit.static_points import Balance, linearised, spread_at
from synth.fit.uncertainty import LOOSE_RATE
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.leg_model import Leg, Spring
from synth.swing.mechanics import coefficients, rest_pose, static_torque
from synth.units import quantity

AIM = np.log(1.1) / NORMAL90  # standard deviation of a log rate: +-10 % at 90 %
TORQUE_SHARES = (0.1, 0.05, 0.03, 0.02, 0.01, 0.005)  # of the torque: accuracy of gauges, the least accurate first
ANGLE_ERRORS = np.radians([1.0, 0.5, 0.2])  # rad, of the reading: by eye, protractor, encoder
ANGLES = 25  # tried over the joint's travel
TIP_SHARES = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0)  # of the leg's mass, attached at its tip
FARTHEST_SAG = np.radians(45.0)  # of any joint: a spring's travel is limited
HOLDING_STIFFNESS = 1e6  # times the stiffest spring, as of the trials' equilibria
NOTHING_TOLD = 1e-12  # of the most told direction: below, a direction of two is rounding
WORTH = 0.8  # of the interval now, that with the point: a point that narrows it by less than a fifth is not proposed
LEAST_AWAY = np.radians(3.0)  # a point nearer to the rest pose does not determine the rate


@dataclass(frozen=True)
class Proposal:
    """A static point worth measuring.

    ``angles`` (n,) rad measured, the pose; ``torque`` N m about ``joint`` in the measured sense; errors as standard
    deviations; ``now`` the spring rate with its reported interval, ``before`` and ``after`` the 90 % half-width as a
    factor minus one. ``spread`` rad, of the free angle in the pose, which ``after`` allows for. ``tip_mass`` kg: a mass
    that could replace the torque, ``tip_angle`` rad the joint's angle with it, and ``tip_after``.
    """

    joint: str
    joint_names: tuple[str, ...]
    angles: Array
    torque: float
    torque_error: float
    angle_error: float
    now: Estimate
    before: float
    after: float
    spread: float = 0.0
    tip_mass: float | None = None
    tip_angle: float | None = None
    tip_after: float | None = None

    @property
    def sentence(self) -> str:
        """What to do, how accurately, and its benefit."""
        j = self.joint_names.index(self.joint)
        angle, turned = np.degrees(self.angles[j]), quantity_text(abs(self.torque), "N*m")
        others = [
            f"{name} {np.degrees(a):.0f} deg"
            for name, a in zip(self.joint_names, self.angles, strict=True)
            if name != self.joint
        ]
        sense = "the way its angle grows" if self.torque > 0 else "the way its angle falls"
        pose = f" with {' and '.join(others)}" if others else ""
        text = (
            f"{self.joint}: hold it still at {angle:.0f} deg{pose}, by about {turned} about the {self.joint}, {sense}. "
            f"The torque read to +-{quantity_text(self.torque_error, 'N*m')} and the angle to "
            f"+-{np.degrees(self.angle_error):.1f} deg (one standard deviation) would fix the spring rate to "
            f"{share_text(self.after)} (90 %); now it is {self.now.words}"
        )
        if self.tip_mass is not None and self.tip_angle is not None and self.tip_after is not None:
            text += (
                f". Or hang {1e3 * self.tip_mass:.0f} g at the tip: the {self.joint} comes to rest near "
                f"{np.degrees(self.tip_angle):.0f} deg, and the pose then read to "
                f"+-{np.degrees(self.angle_error):.1f} deg fixes it to {share_text(self.tip_after)}"
            )
        if self.spread > 0.0:
            text += (
                ". That allows for a free angle that shifts as from trial to trial; poses of one `session` with "
                "different torques share the shift and tell more"
            )
        return f"{text}. Enter it under static: in the project"

    @property
    def brief(self) -> str:
        """One line: what is known now, and what one pose would tell."""
        return (
            f"{self.joint}: its spring rate is {self.now.words} (90 %); one pose held by "
            f"{quantity_text(abs(self.torque), 'N*m')} would fix it to {share_text(self.after)}"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry under ``proposals``."""
        written: dict[str, Any] = {
            "joint": self.joint,
            "text": self.sentence,
            "angles": {n: quantity(float(a), "deg") for n, a in zip(self.joint_names, self.angles, strict=True)},
            "torque": quantity(self.torque, "N*m"),
            "torque_error": quantity(self.torque_error, "N*m"),
            "angle_error": quantity(self.angle_error, "deg"),
            "spring_rate_within": {"now": quantity(self.before, "1"), "then": quantity(self.after, "1")},
        }
        if self.tip_mass is not None and self.tip_angle is not None and self.tip_after is not None:
            written["or_tip_mass"] = {
                "tip_mass": quantity(self.tip_mass, "g"),
                "rest_angle": quantity(self.tip_angle, "deg"),
                "then": quantity(self.tip_after, "1"),
            }
        return written


def proposals(
    unknowns: SpringsAndDampers,
    recordings: Sequence[Recording],
    values: Array,
    known: Known,
    spread: Array | None = None,
) -> tuple[Proposal, ...]:
    """A static point for every joint whose spring rate is not determined by the trials and existing points.

    Only those that make the reported interval narrower; none of a spring that is not told from none. ``spread`` (n,)
    rad of the points' free angles, as in ``Weights.points``.
    """
    found = []
    for place, j in enumerate(unknowns.rates):
        loose = known.deviation(place) > LOOSE_RATE and np.isfinite(known.ends[0][place])
        if loose and any(j in recording.free for recording in recordings):
            proposal = _proposal(unknowns, recordings, values, known, j, spread_at(spread, j))
            if proposal is not None and np.log1p(proposal.after) <= WORTH * np.log1p(proposal.before):
                found.append(proposal)
    return tuple(found)


def _proposal(
    unknowns: SpringsAndDampers, recordings: Sequence[Recording], values: Array, known: Known, j: int, spread: float
) -> Proposal | None:
    """The point that determines joint ``j``'s rate best, with the least accurate reading that reaches the goal."""
    leg, place = unknowns.leg, unknowns.rate_at(j)
    fitted = _clamped(unknowns, unknowns.fitted_leg(values), recordings)
    try:
        pose = rest_pose(fitted)
    except ArithmeticError:
        return None  # a leg without equilibrium cannot be held still by a torque at one joint
    rate, rest = float(np.exp(values[place])), float(values[unknowns.rest_at(j)])
    points = []
    for angle in _travel(leg, recordings, j):
        if abs(angle - pose[j]) < LEAST_AWAY:
            continue
        held = pose.copy()
        held[j] = angle
        weight = float(static_torque(coefficients(leg), held, leg.tilt)[j])
        spring = rate * (angle - rest)
        points.append((held, spring + weight, spring, known.weight * abs(weight)))
    if not points:
        return None
    readings = [(share, error) for error in ANGLE_ERRORS for share in TORQUE_SHARES]
    best: tuple[float, int, float, float] | None = None
    for share, angle_error in readings:
        for index, (held, torque, spring, of_weight) in enumerate(points):
            error = max(share * abs(torque), 1e-9)
            point = Balance("", j, float(held[j]), spring, float(np.hypot(error, of_weight)), angle_error)
            after = _deviation_after_point(unknowns, values, known.total, point, spread)
            if best is None or after < best[0]:
                best = after, index, error, angle_error
        assert best is not None
        if best[0] <= AIM:
            break
    assert best is not None
    held, torque, *_ = points[best[1]]
    made = Proposal(
        leg.joint_names[j],
        leg.joint_names,
        leg.to_measured(held),
        float(leg.sign[j] * torque),
        best[2],
        best[3],
        known.estimates[f"spring_rate {leg.joint_names[j]}"],
        known.half_width(place),
        half_width(best[0]),
        spread,
    )
    return _with_tip_mass(made, unknowns, fitted, pose, values, known, j)


def _clamped(unknowns: SpringsAndDampers, leg: Leg, recordings: Sequence[Recording]) -> Leg:
    """The leg with joints that no recording moves held, by a stiff spring, where the first one has them."""
    held = [j for j in range(len(leg.joints)) if j not in unknowns.rates]
    angles = leg.to_measured(recordings[0].smoothed.angle[0])
    stiff = HOLDING_STIFFNESS * max(joint.spring.rate for joint in leg.joints if joint.spring is not None)
    return leg.with_joints(**{leg.joint_names[j]: {"spring": Spring(stiff, float(angles[j]))} for j in held})


def _with_tip_mass(
    made: Proposal, unknowns: SpringsAndDampers, fitted: Leg, pose: Array, values: Array, known: Known, j: int
) -> Proposal:
    """The proposal with the smallest mass at the tip that reaches the goal, if any."""
    leg = unknowns.leg
    mass = sum(joint.link.mass for joint in leg.joints)
    for share in TIP_SHARES:
        try:
            hung = rest_pose(fitted, share * mass, pose)
        except ArithmeticError:
            break
        if np.abs(hung - pose).max() > FARTHEST_SAG:
            break
        spring = -float(static_torque(coefficients(leg, share * mass), hung, leg.tilt)[j])
        error = max(known.weight * abs(spring), 1e-9)
        point = Balance("", j, float(hung[j]), spring, error, made.angle_error)
        after = _deviation_after_point(unknowns, values, known.total, point, made.spread)
        if after <= AIM:
            angle = float(leg.to_measured(hung)[j])
            return replace(made, tip_mass=share * mass, tip_angle=angle, tip_after=half_width(after))
    return made


def _deviation_after_point(
    unknowns: SpringsAndDampers, values: Array, known: Array, point: Balance, spread: float
) -> float:
    """Standard deviation of the log rate with one more point (Woodbury on the covariance ``known`` (p, p)).

    ``spread`` rad of the points' free angles, which may be one with that of points that the joint has already.
    """
    places = [unknowns.rate_at(point.joint), unknowns.rest_at(point.joint)]
    beside = [each for each in unknowns.balances if (each.joint, each.session) == (point.joint, point.session)]

    def information(some: Sequence[Balance]) -> Array:
        slope = linearised(some, float(values[places[0]]), float(values[places[1]]), spread)[1]
        return np.asarray(slope.T @ slope)

    added = information([*beside, point]) - (information(beside) if beside else 0.0)
    near = known[np.ix_(places, places)]
    # By the directions that the point tells of: where a rate is open, near is so large that a 1 beside it is lost.
    told, ways = np.linalg.eigh(added)
    kept = told > NOTHING_TOLD * told[-1]
    slopes = np.sqrt(told[kept])[:, None] * ways.T[kept]
    seen = slopes @ near[0]
    fall = seen @ np.linalg.solve(np.eye(len(seen)) + slopes @ near @ slopes.T, seen)
    return float(np.sqrt(np.clip(near[0, 0] - fall, 0.0, near[0, 0])))


def _travel(leg: Leg, recordings: Sequence[Recording], j: int) -> Array:
    """(m,) rad, rotations to try: the joint's range in the leg file, else its range in the trials."""
    joint = leg.joints[j]
    if joint.ends is not None:
        low, high = joint.ends
    else:
        moved = [r.smoothed.angle[:, j] for r in recordings if j in r.free]
        low, high = min(float(m.min()) for m in moved), max(float(m.max()) for m in moved)
    return np.linspace(low, high, ANGLES)


def share_text(share: float) -> str:
    """A half-width in words."""
    return "no better than a factor of four" if share > 3 else f"+-{quantity_text(100 * share, '%')}"


def quantity_text(value: float, unit: str) -> str:
    """Two digits and the unit."""
    return f"{float(f'{value:.2g}'):g} {unit}"
