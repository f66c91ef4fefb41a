"""Messages specific to a jumping leg: causes, errors, heights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, UNITS, Jump, factor_of, pooled_noise
from synth.diagnosis.plants.jumping_leg.jump_figures import Rise
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump
from synth.diagnosis.prediction_error import AT_NOISE, PredictionErrors
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


def other_channels_text(trials: Sequence[Jump], before: Sequence[ScoredJump], after: Sequence[ScoredJump]) -> str:
    """The channels beside the angle whose error is above the noise within tolerances, and falls with the explanation.

    ``before``, ``after`` : the predictions of the scored ``trials``.
    """
    falls = []
    for channel in dict.fromkeys(name for trial in trials for name in trial.measured if name != ANGLE):
        noise = pooled_noise(trials, channel)
        start, end = (_error(trials, predicted, channel) for predicted in (before, after))
        if start > AT_NOISE * noise and end < start:
            shown = [significant(value / factor_of(channel), 2) for value in (start, end, noise)]
            falls.append(f"{channel} from {shown[0]} to {shown[1]} {UNITS[channel]} (noise {shown[2]})")
    return f" The cause shows in other readings, whose error it reduces: {', '.join(falls)}." if falls else ""


def _error(trials: Sequence[Jump], predicted: Sequence[ScoredJump], channel: str) -> float:
    """RMS error of a channel over the trials that have it, SI; nan where a prediction ends before a trial."""
    away = [
        told.channels[channel] - trial.measured[channel]
        for trial, told in zip(trials, predicted, strict=True)
        if channel in trial.measured
    ]
    return float(np.sqrt(np.mean(np.concatenate(away) ** 2)))


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
