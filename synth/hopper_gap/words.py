"""The diagnosis of a jumping leg in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

from synth.effects.motor_leg import motor_effect_named
from synth.fit.result import Estimate
from synth.gap.result import Cause, Verdict
from synth.gap.words import angle
from synth.hopper_gap.figures import Rise

SUBJECTS = {"hip": "the motors", "all": "the joints", "base": "the ground"}


def cause_text(cause: Cause) -> str:
    """The joints have more damping than the design (damping 0.00046 N·m·s/rad)."""
    values = ", ".join(f"{name.replace('_', ' ')} {_shown(estimate)}" for name, estimate in cause.parameters.items())
    return f"{SUBJECTS[cause.joint]} {motor_effect_named(cause.effect).phrase} ({values})"


def _shown(estimate: Estimate) -> str:
    written = estimate.as_json()
    unit = str(written["unit"]).replace("*", "·").replace("percent", "%")
    return f"{written['value']:.3g}" + ("" if unit == "1" else f" {unit}")


def sentence(
    verdict: Verdict, causes: Sequence[Cause], tied: Sequence[Sequence[Cause]], probability: float,
    designed: Estimate, before: Estimate, after: Estimate, floor: Estimate, held_out: bool, rises: Sequence[Rise],
) -> str:  # fmt: skip
    """The whole diagnosis in one or two sentences."""
    on = "unseen trials" if held_out else "each trial, predicted by the others"
    if verdict == "none":
        return (
            f"Nothing is missing that these trials would show: within its tolerances the design's upper link is "
            f"{angle(before)} off on {on}, the readings' noise being {angle(floor)}."
        )
    if verdict == "unknown":
        nearest = f"the best explanation leaves {angle(after)}"
        if after.value >= before.value:
            nearest = "no explanation helps there"
        return (
            f"Something is missing that no effect in the library explains: the upper link's error on {on} is "
            f"{angle(before)}, {nearest}, the noise is {angle(floor)}."
        )
    text = " and ".join(cause_text(cause) for cause in causes)
    falls = (
        f"the upper link's error on {on} falls from {angle(designed)} as designed, {angle(before)} at the tolerances' "
        "best, to"
    )
    if verdict == "tie":
        ways = " or ".join(" and ".join(cause_text(c) for c in option) for option in tied[:2])
        return (
            f"Either {text}, or {ways}: these trials cannot tell them apart. With any of them {falls} about "
            f"{angle(after)}, noise {angle(floor)}."
        )
    first = text[0].upper() + text[1:]
    return f"{first}, {100 * probability:.0f} %; with it {falls} {angle(after)}, noise {angle(floor)}.{_rise(rises)}"


def _rise(rises: Sequence[Rise]) -> str:
    """How the predicted rise changes, where a plate tells the measured one."""
    known = [r for r in rises if r.measured and r.as_designed is not None and r.after is not None]
    if not known:
        return ""
    measured, designed, after = (
        100.0 * sum(getattr(r, name) for r in known) / len(known) for name in ("measured", "as_designed", "after")
    )
    return f" The jumps rise {measured:.2g} cm; as designed {designed:.2g} cm was predicted, with it {after:.2g} cm."
