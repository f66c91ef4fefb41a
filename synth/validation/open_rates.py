"""Joints whose recordings leave k and b open along b/k: the springs and dampers that fit about equally well there.

They are those of the fit itself (``fit.ridge_family``): the same recordings, weights, priors and static points, with
the damper rate held at each of several values and everything else that the fit estimates refitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import Estimate
from synth.fit.fit_result import FitResult
from synth.fit.ridge import SAME_QUOTIENT
from synth.fit.ridge_family import FamilyMember, RidgeFamily
from synth.validation.comparison_table import listed

RANGES = (
    "Where recordings leave k and b of a joint open along b/k, the range of least squares holds, beside the 90 % "
    "interval, all springs or dampers that fit about equally well."
)


def family_of(fit: FitResult, joint: str) -> RidgeFamily | None:
    """The springs and dampers that fit a joint about equally well; None if the recordings tell k and b."""
    return next((family for family in fit.families if family.joint == joint), None)


def shown_rates(fit: FitResult, joint: str) -> tuple[Estimate, Estimate]:
    """A joint's spring and damper rate; ranges as in ``RANGES``, without an upper end where a family has none."""
    found, family = fit.joints[joint], family_of(fit, joint)
    assert found.damper_rate is not None
    if family is None:
        return found.spring_rate, found.damper_rate
    springs = [member.spring_rate for member in family.members]
    dampers = [member.damper_rate for member in family.members]
    return (
        _reaching(found.spring_rate, springs, open_end=family.open_end),
        _reaching(found.damper_rate, dampers, open_end=family.open_end),
    )


def within_interval(estimate: Estimate, value: float) -> bool:
    """Whether ``value`` lies within the estimate's 90 % interval or range."""
    return estimate.low is not None and estimate.high is not None and estimate.low <= value <= estimate.high


def inside_words(fit: FitResult, joint: str, published: Array) -> str:
    """Whether a published pair (2,), N m/rad and N m s/rad, lies in the ranges shown: ``k inside and b outside ..``."""
    pairs = zip("kb", shown_rates(fit, joint), published, strict=True)
    words = [f"{symbol} {'inside' if within_interval(e, value) else 'outside'}" for symbol, e, value in pairs]
    return f"{listed(words)} our {'90 % intervals' if family_of(fit, joint) is None else 'ranges'}"


def family_sentence(fit: FitResult, joint: str, published: Array) -> str | None:
    """What fits a joint about equally well, and whether a published pair (2,) is of it; None without such a family."""
    family = family_of(fit, joint)
    if family is None:
        return None
    soft, stiff = family.members[0], family.members[-1]
    quotients = [member.damper_rate / member.spring_rate for member in family.members]
    errors = [float(np.degrees(member.rms)) for member in family.members]
    return (
        f"{joint}: springs of {soft.spring_rate:.3g} to {stiff.spring_rate:.3g} N*m/rad"
        f"{' and beyond' if family.open_end else ''} fit about equally well, each with its own damper "
        f"({soft.damper_rate:.3g} to {stiff.damper_rate:.3g} N*m*s/rad) and all else that our fit estimates refitted: "
        f"overall RMS {min(errors):.3g} to {max(errors):.3g} deg, b/k {min(quotients):.3g} to {max(quotients):.3g} s. "
        f"{_place_of(family, float(published[0]), float(published[1]))}"
    )


def among(family: RidgeFamily, spring_rate: float) -> bool:
    """Whether a spring of this rate, N m/rad, lies between the softest and the stiffest of a family."""
    return family.members[0].spring_rate <= spring_rate <= family.members[-1].spring_rate


def _place_of(family: RidgeFamily, spring_rate: float, damper_rate: float) -> str:
    """A sentence on a published pair, N m/rad and N m s/rad, against the pairs of a family."""
    members = family.members
    if not among(family, spring_rate):
        beyond = family.open_end and spring_rate > members[-1].spring_rate
        return f"The published k is {'beyond the last of these fits' if beyond else 'not among them'}."
    belongs = _belonging(spring_rate, members, "spring_rate", "damper_rate")
    if abs(np.log(belongs / damper_rate)) <= SAME_QUOTIENT:
        return "The published pair is among them."
    text = f"The published k is among them, but with b = {belongs:.2g} N*m*s/rad instead of {damper_rate:.3g}"
    if members[0].damper_rate <= damper_rate <= members[-1].damper_rate:
        text += f"; to the published b belongs k = {_belonging(damper_rate, members, 'damper_rate', 'spring_rate'):.2g}"
        text += " N*m/rad"
    return f"{text}."


def _belonging(value: float, members: Sequence[FamilyMember], known: str, sought: str) -> float:
    """The rate ``sought`` of a pair whose rate ``known`` is ``value``, between members a factor of two apart."""
    rates = np.log([[getattr(member, key) for key in (known, sought)] for member in members])
    at, found = rates[np.argsort(rates[:, 0])].T
    return float(np.exp(np.interp(np.log(value), at, found)))


def _reaching(estimate: Estimate, values: Sequence[float], *, open_end: bool) -> Estimate:
    """The estimate with an interval that holds ``values`` too."""
    ends = [end for end in (estimate.low, estimate.high) if end is not None]
    return replace(estimate, low=min([*ends, *values]), high=np.inf if open_end else max([*ends, *values]))
