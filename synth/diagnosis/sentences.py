"""The diagnosis in a sentence; what differs between a swinging and a jumping leg is given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from synth.diagnosis.result import Cause, Verdict
from synth.estimation.intervals import Estimate

BETTER = {"*": "·", "deg": "°", "percent": "%"}  # as units are printed


@dataclass(frozen=True)
class ErrorWording:
    """What the sentence says of the errors.

    ``nominal`` : what is compared with the trials, "the nominal leg"; ``error`` : "the error"; ``on`` : where it is
    taken, see ``scored_on``; ``falls_from`` : the error that a cause makes smaller, "2.1°".
    """

    nominal: str
    error: str
    on: str
    falls_from: str
    before: Estimate
    after: Estimate
    floor: Estimate


def scored_on(held_out: bool, trials: str) -> str:
    """Unseen releases, if ``trials`` are releases."""
    return f"unseen {trials}" if held_out else "each trial, predicted by the others,"


def angle(value: Estimate) -> str:
    """An angle in degrees to two digits."""
    return f"{math.degrees(value.value):.2g}°"


def parameters_text(cause: Cause) -> str:
    """Torque 0.052 N·m, presliding 0.3°."""
    return ", ".join(f"{name.replace('_', ' ')} {_shown(estimate)}" for name, estimate in cause.parameters.items())


def _shown(estimate: Estimate) -> str:
    written = estimate.as_json()
    unit = str(written["unit"])
    for plain, better in BETTER.items():
        unit = unit.replace(plain, better)
    return f"{written['value']:.3g}" + ("" if unit == "1" else f" {unit}").replace(" °", "°")


def sentence(
    verdict: Verdict, causes: Sequence[str], tied: Sequence[Sequence[str]], probability: float, told: ErrorWording
) -> str:
    """The whole diagnosis in one or two sentences; ``causes`` and those of each ``tied`` explanation in words."""
    error, floor, after = f"{told.error} on {told.on}", angle(told.floor), angle(told.after)
    if verdict == "none":
        return (
            f"Nothing is missing that these trials would show: within its tolerances {told.nominal} is "
            f"{angle(told.before)} off on {told.on.rstrip(',')}, the readings' noise being {floor}."
        )
    if verdict == "unknown":
        helps = told.after.value < told.before.value
        nearest = f"the best explanation leaves {after}" if helps else "no explanation helps there"
        return (
            f"Something is missing that no effect in the library explains: {error} is {angle(told.before)}, "
            f"{nearest}, the noise is {floor}."
        )
    text = " and ".join(causes)
    if verdict == "tie":
        ways = " or ".join(" and ".join(option) for option in tied[:2])
        return (
            f"Either {text}, or {ways}: these trials cannot tell them apart. With any of them {error} falls from "
            f"{told.falls_from} to about {after}, noise {floor}."
        )
    them = {1: "it", 2: "both"}.get(len(causes), "all of them")
    return (
        f"{text[0].upper()}{text[1:]}, {100 * probability:.0f} %; with {them} {error} falls from "
        f"{told.falls_from} to {after}, noise {floor}."
    )


def what_is_open(verdict: Verdict, explanations: Sequence[str]) -> str:
    """Why another trial: ``explanations`` are the one accepted and those tied with it, in words."""
    if verdict == "tie":
        return f"{', '.join(explanations[:-1])} and {explanations[-1]} explain these trials alike."
    if verdict == "none":
        return "Nothing is missing as far as these trials reach; this is where the likeliest causes would show first."
    if verdict == "unknown":
        return "What is missing is not known; the explanations that come nearest part most here."
    return "To be surer of the cause against the next likeliest."
