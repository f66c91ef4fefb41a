"""The diagnosis of a jumping leg in a sentence: that of a swinging one in the jump's words, and how high it rises."""

from __future__ import annotations

from collections.abc import Sequence

from synth.diagnosis.jumps.jump_figures import JumpGaps, Rise
from synth.diagnosis.result import Cause, Verdict
from synth.diagnosis.sentences import Told, angle, parameters_text, scored_on
from synth.diagnosis.sentences import sentence as sentence_of
from synth.jump.effects import motor_effect_named

SUBJECTS = {"hip": "the motors", "all": "the joints", "base": "the ground"}


def cause_text(cause: Cause) -> str:
    """The joints have more damping than the design (damping 0.00046 N·m·s/rad)."""
    return f"{SUBJECTS[cause.joint]} {motor_effect_named(cause.effect).phrase} ({parameters_text(cause)})"


def sentence(
    verdict: Verdict, causes: Sequence[Cause], tied: Sequence[Sequence[Cause]], probability: float,
    gaps: JumpGaps, held_out: bool,
) -> str:  # fmt: skip
    """The whole diagnosis in one to three sentences."""
    designed, before, after = (gaps.misses.figure(stage) for stage in ("as_designed", "before", "after"))
    told = Told(
        nominal="the design's upper link",
        error="the upper link's error",
        on=scored_on(held_out, "trials"),
        falls_from=f"{angle(designed)} as designed, {angle(before)} at the tolerances' best,",
        before=before,
        after=after,
        floor=gaps.misses.floor,
    )
    explanations = [[cause_text(cause) for cause in option] for option in (causes, *tied)]
    text = sentence_of(verdict, explanations[0], explanations[1:], probability, told)
    return text + (_rise(gaps.rises) if verdict == "effect" else "")


def _rise(rises: Sequence[Rise]) -> str:
    """How the predicted rise changes, where a plate tells the measured one."""
    known = [r for r in rises if r.measured and r.as_designed is not None and r.after is not None]
    if not known:
        return ""
    measured, designed, after = (
        100.0 * sum(getattr(r, name) for r in known) / len(known) for name in ("measured", "as_designed", "after")
    )
    return f" The jumps rise {measured:.2g} cm; as designed {designed:.2g} cm was predicted, with it {after:.2g} cm."
