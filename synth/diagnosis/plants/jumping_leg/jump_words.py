"""What the diagnosis of a jumping leg says in words of its own: its causes, its error, how high it rises."""

from __future__ import annotations

from collections.abc import Sequence

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.jumping_leg.jump_figures import Rise
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.sentences import ErrorWording, angle, parameters_text, scored_on
from synth.jump.effects import motor_effect_named

SUBJECTS = {"hip": "the motors", "all": "the joints", "base": "the ground"}


def cause_text(cause: Cause) -> str:
    """The joints have more damping than the design (damping 0.00046 N·m·s/rad)."""
    return f"{SUBJECTS[cause.joint]} {motor_effect_named(cause.effect).phrase} ({parameters_text(cause)})"


def wording(errors: PredictionErrors, held_out: bool) -> ErrorWording:
    """How the sentence speaks of the upper link's error."""
    designed, before, after = (errors.figure(stage) for stage in ("as_designed", "before", "after"))
    return ErrorWording(
        nominal="the design's upper link",
        error="the upper link's error",
        on=scored_on(held_out, "trials"),
        falls_from=f"{angle(designed)} as designed, {angle(before)} at the tolerances' best,",
        before=before,
        after=after,
        floor=errors.floor,
    )


def rise_text(rises: Sequence[Rise]) -> str:
    """How the predicted rise changes, where a plate tells the measured one."""
    known = [r for r in rises if r.measured and r.as_designed is not None and r.after is not None]
    if not known:
        return ""
    measured, designed, after = (
        100.0 * sum(getattr(r, name) for r in known) / len(known) for name in ("measured", "as_designed", "after")
    )
    return f" The jumps rise {measured:.2g} cm; as designed {designed:.2g} cm was predicted, with it {after:.2g} cm."
