"""Messages specific to a jumping leg: causes, errors, heights."""

from __future__ import annotations

from collections.abc import Sequence

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.jumping_leg.jump_figures import Rise
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.sentences import ErrorWording, angle_text, scored_on, stated_parameters
from synth.jump.effects import motor_effect_named
from synth.units import significant

SUBJECTS = {"hip": "the motors", "all": "the joints", "base": "the ground"}


def cause_text(cause: Cause) -> str:
    """The joints have more damping than the design (damping 0.00046 N·m·s/rad)."""
    effect = motor_effect_named(cause.effect)
    values = stated_parameters(cause, effect)
    return f"{SUBJECTS[cause.joint]} {effect.phrase}" + (f" ({values})" if values else "")


def wording(errors: PredictionErrors, *, held_out: bool) -> ErrorWording:
    """The words of the sentence for the upper link's error."""
    designed, before, after = (errors.figure(stage) for stage in ("as_designed", "before", "after"))
    return ErrorWording(
        nominal="the design's upper link",
        error="the upper link's error",
        on=scored_on("trials", held_out=held_out),
        falls_from=f"{angle_text(designed)} as designed, {angle_text(before)} fitted within tolerances,",
        before=before,
        after=after,
        floor=errors.floor,
    )


def rise_text(rises: Sequence[Rise]) -> str:
    """How the predicted rise changes, if a plate has measured it."""
    known = [r for r in rises if r.measured and r.as_designed is not None and r.after is not None]
    if not known:
        return ""
    measured, designed, after = (
        100.0 * sum(getattr(r, name) for r in known) / len(known) for name in ("measured", "as_designed", "after")
    )
    texts = [significant(height, 2) for height in (measured, designed, after)]
    return f" The jumps rise {texts[0]} cm; the design predicts {texts[1]} cm, the explanation {texts[2]} cm."
