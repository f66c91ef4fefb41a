"""The diagnosis in a sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

from synth.effects import effect_named
from synth.fit.result import Estimate
from synth.gap.result import Cause, Verdict


def angle(value: Estimate) -> str:
    """An angle in degrees to two digits."""
    return f"{math.degrees(value.value):.2g}°"


def cause_text(cause: Cause) -> str:
    """The knee lacks dry friction (torque 0.052 N·m)."""
    place = "base" if cause.joint == "base" else cause.joint
    effect = effect_named(cause.effect)
    phrase = effect.phrase or f"shows {effect.meaning}"
    values = ", ".join(f"{name.replace('_', ' ')} {_shown(estimate)}" for name, estimate in cause.parameters.items())
    return f"the {place} {phrase}" + (f" ({values})" if values else "")


def _shown(estimate: Estimate) -> str:
    written = estimate.as_json()
    unit = str(written["unit"]).replace("*", "·").replace("deg", "°")
    return f"{written['value']:.3g}" + ("" if unit == "1" else f" {unit}").replace(" °", "°")


def sentence(
    verdict: Verdict,
    causes: Sequence[Cause],
    tied: Sequence[Sequence[Cause]],
    probability: float,
    before: Estimate,
    after: Estimate,
    floor: Estimate,
    held_out: bool,
) -> str:
    """The whole diagnosis in one or two sentences."""
    on = "unseen releases" if held_out else "each trial, predicted by the others,"
    if verdict == "none":
        return (
            f"Nothing is missing that these trials would show: within its tolerances the nominal leg is "
            f"{angle(before)} off on {on.rstrip(',')}, the readings' noise being {angle(floor)}."
        )
    if verdict == "unknown":
        nearest = f"the best explanation leaves {angle(after)}, "
        if after.value >= before.value:
            nearest = "no explanation helps there, "
        return (
            f"Something is missing that no effect in the library explains: the error on {on} is {angle(before)}, "
            f"{nearest}the noise is {angle(floor)}."
        )
    text = " and ".join(cause_text(cause) for cause in causes)
    if verdict == "tie":
        ways = " or ".join(" and ".join(cause_text(c) for c in option) for option in tied[:2])
        return (
            f"Either {text}, or {ways}: these trials cannot tell them apart. With any of them the error on {on} falls "
            f"from {angle(before)} to about {angle(after)}, noise {angle(floor)}."
        )
    first = text[0].upper() + text[1:]
    them = {1: "it", 2: "both"}.get(len(causes), "all of them")
    return (
        f"{first}, {100 * probability:.0f} %; with {them} the error on {on} falls from {angle(before)} to "
        f"{angle(after)}, noise {angle(floor)}."
    )
