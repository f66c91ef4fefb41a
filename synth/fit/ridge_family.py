"""The springs and dampers that fit a joint equally well, where the trials determine little but b/k.

One pair with its interval hides that only pairs of one quotient fit. The family lists such pairs: the damper rate is
fixed at steps of a factor of two from the reported one, both ways, everything else is refitted, and the steps end
where the fit becomes worse than allowed (a profile: Raue et al., Bioinformatics 25 (2009) 1923).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.fit_problem import unknowns_of
from synth.fit.least_squares import Solution, Stage
from synth.fit.recordings import Recording
from synth.fit.ridge import ALLOWANCE, POINTS_COST, SAME_QUOTIENT, RidgeSearch, loose_joints, overall_rms, static_cost
from synth.fit.trajectories import TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers
from synth.remarks import Remark, at_joint
from synth.units import quantity

FACTOR = np.log(2.0)  # between neighbouring members: five span a factor of sixteen
MOST_STEPS = 6  # to each side: a factor of 64, beyond what anyone would call the same joint
BISECTIONS = 3  # of the last step: an end is known to a factor of 2^(1/8), 9 %
# RMS off the reported motion, over its RMS error: an independent error of this size adds ALLOWANCE to the RMS.
MOST_APART = np.sqrt((1.0 + ALLOWANCE) ** 2 - 1.0)
ITERATIONS = 6  # along a ridge two or three suffice; what fits well enough need not be the optimum
COST_RISE = 0.5 * NORMAL90**2  # of the negative log-likelihood within a 90 % interval of one parameter


@dataclass(frozen=True)
class FamilyMember:
    """One spring and damper, everything else refitted.

    ``spring_rate`` N m/rad, ``damper_rate`` N m s/rad, ``free_angle`` rad as measured; ``rms`` rad over all joints
    and trials; ``difference`` rad, RMS between its motion and that of the reported fit.
    """

    spring_rate: float
    damper_rate: float
    free_angle: float
    rms: float
    difference: float

    def as_json(self) -> dict[str, Any]:
        """The member with units."""
        return {
            "spring_rate": quantity(self.spring_rate, "N*m/rad"),
            "damper_rate": quantity(self.damper_rate, "N*m*s/rad"),
            "free_angle": quantity(self.free_angle, "deg"),
            "rms": quantity(self.rms, "deg"),
            "difference": quantity(self.difference, "deg"),
        }


@dataclass(frozen=True)
class RidgeFamily:
    """The equally good members of a joint, softest first; ``open_end``: the stiffest is not an end of the family."""

    joint: str
    members: tuple[FamilyMember, ...]
    open_end: bool

    @property
    def sentence(self) -> Remark:
        """The range of the family, and how little its members differ."""
        soft, stiff = self.members[0], self.members[-1]
        further = " and beyond" if self.open_end else ""
        errors = np.degrees([member.rms for member in self.members])
        low, high = f"{errors.min():.2g}", f"{errors.max():.2g}"
        rms = f"{low} deg" if low == high else f"{low} to {high} deg"
        difference = np.degrees(max(member.difference for member in self.members))
        text = (
            f"springs of {soft.spring_rate:.3g} to {stiff.spring_rate:.3g} N*m/rad{further} fit about "
            f"equally well, each with its own damper ({soft.damper_rate:.3g} to {stiff.damper_rate:.3g} N*m*s/rad): "
            f"overall RMS {rms}, and their motions differ by at most {difference:.2g} deg RMS. Any of them may be "
            "built; a `static:` point tells which one the animal has"
        )
        return at_joint(self.joint, text)

    def as_json(self) -> dict[str, Any]:
        """The entry of ``families``."""
        return {
            "joint": self.joint,
            "members": [member.as_json() for member in self.members],
            "open_end": self.open_end,
            "text": str(self.sentence),
        }


def families(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, least: Solution | None
) -> tuple[RidgeFamily, ...]:
    """The family of every joint whose spring and damper rate are not separable.

    ``least`` : the solution of least residual, if the model lacks an effect and the stage was moved from there;
    members may then have ``ALLOWANCE`` more than its overall RMS. Else their cost stays within a 90 % interval.
    """
    reported = stage.solution
    limits = _Limits(
        recordings,
        reported.predictions,
        unknowns_of(model),
        difference=MOST_APART * overall_rms(recordings, reported),
        points=static_cost(unknowns_of(model), reported.values, stage.weights.points) + POINTS_COST,
        spread=stage.weights.points,
    )
    if least is None:
        limits = replace(limits, cost=reported.cost + COST_RISE)
    else:
        limits = replace(limits, rms=(1.0 + ALLOWANCE) * overall_rms(recordings, least))
    loose = sorted({*loose_joints(model, least or reported), *loose_joints(model, reported)})
    found = [_FamilySearch(model, recordings, stage, limits).family(joint) for joint in loose]
    return tuple(family for family in found if len(family.members) > 1)


@dataclass(frozen=True)
class _Limits:
    """Upper limits of a member: cost, overall RMS (rad), RMS (rad) off the reported motion, cost of static points.

    ``spread`` (n,) rad of the static points' free angles.
    """

    recordings: Sequence[Recording]
    reported: Sequence[Array]
    unknowns: SpringsAndDampers
    difference: float
    points: float
    cost: float = np.inf
    rms: float = np.inf
    spread: Array | None = None

    def allow(self, found: Solution) -> bool:
        """Whether a solution fits trials and static points as well as the reported one, and moves alike."""
        if not (found.cost <= self.cost and overall_rms(self.recordings, found) <= self.rms):
            return False
        if static_cost(self.unknowns, found.values, self.spread) > self.points:
            return False
        return rms_difference(self.recordings, found.predictions, self.reported) <= self.difference


@dataclass(frozen=True)
class _FamilySearch:
    model: TrajectoryModel
    recordings: Sequence[Recording]
    stage: Stage
    limits: _Limits

    def family(self, joint: int) -> RidgeFamily:
        """Members to both sides of the reported one."""
        softer, _ = self._side(joint, -1.0)
        stiffer, open_end = self._side(joint, 1.0)
        solutions = [*reversed(softer), self.stage.solution, *stiffer]
        return RidgeFamily(
            self.model.leg.joint_names[joint], tuple(self._member(joint, found) for found in solutions), open_end
        )

    def _side(self, joint: int, sign: float) -> tuple[list[Solution], bool]:
        """Solutions at growing distance, and whether those beyond might fit too."""
        unknowns = unknowns_of(self.model)
        place = unknowns.damper_at(joint)
        bound = float((unknowns.upper if sign > 0.0 else unknowns.lower)[place])
        start = float(self.stage.solution.values[place])
        reached = self.stage.solution
        members: list[Solution] = []
        for step in range(1, MOST_STEPS + 1):
            wanted = start + sign * step * FACTOR
            if sign * (bound - wanted) <= 0.0:  # the bound of the search itself is the last
                last = self._fit_at_rate(joint, reached, bound)
                return ([*members, last] if last is not None else members), last is not None
            found = self._fit_at_rate(joint, reached, wanted)
            if found is None:
                end = self._end(joint, reached, wanted)
                return ([*members, end] if end is not None else members), False
            reached = found
            members.append(found)
        return members, True

    def _end(self, joint: int, inside: Solution, outside: float) -> Solution | None:
        """The last solution that fits between one that does and a log damper rate that does not."""
        place = unknowns_of(self.model).damper_at(joint)
        end = None
        for _ in range(BISECTIONS):
            middle = 0.5 * (float(inside.values[place]) + outside)
            found = self._fit_at_rate(joint, inside, middle)
            if found is None:
                outside = middle
            else:
                inside = end = found
        return end

    def _fit_at_rate(self, joint: int, near: Solution, log_rate: float) -> Solution | None:
        """The fit with a fixed damper rate, or None if it is not as good or leaves the ridge."""
        unknowns = unknowns_of(self.model)
        k, place = unknowns.rate_at(joint), unknowns.damper_at(joint)
        refits = RidgeSearch(self.model, self.recordings, self.stage.weights, ITERATIONS, clipped=True)
        found = refits.refit(joint, near, log_rate)
        if not np.isfinite(found.cost):
            return None
        along = float(found.values[place] - found.values[k]) - float(near.values[place] - near.values[k])
        return found if abs(along) <= SAME_QUOTIENT and self.limits.allow(found) else None

    def _member(self, joint: int, solution: Solution) -> FamilyMember:
        unknowns, leg = unknowns_of(self.model), self.model.leg
        values = solution.values
        item = leg.joints[joint]
        return FamilyMember(
            float(np.exp(values[unknowns.rate_at(joint)])),
            float(np.exp(values[unknowns.damper_at(joint)])),
            item.zero + item.sign * float(values[unknowns.rest_at(joint)]),
            overall_rms(self.recordings, solution),
            rms_difference(self.recordings, solution.predictions, self.stage.solution.predictions),
        )


def rms_difference(recordings: Sequence[Recording], one: Sequence[Array], other: Sequence[Array]) -> float:
    """RMS over the counted samples between two predictions, rad."""
    apart = [(a - b)[recording.counts] for recording, a, b in zip(recordings, one, other, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(apart) ** 2)))
