"""Whether trials that are held out distinguish explanations that the trials learnt from do not.

Held-out trials never choose between explanations (``../shared/FORMATS.md``). Where one of them would end a tie the user
is told, and may let it count.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.sentences import angle_text
from synth.estimation.intervals import Estimate
from synth.remarks import decisive

CLEARLY_WORSE = 2.0  # RMS error over that of the best explanation, or over the noise if that is larger: a choice
MOST_EXPLANATIONS = 3  # told of one trial


def held_out_trial_that_distinguishes(
    errors: PredictionErrors, labels: Sequence[str], words: Sequence[str], names: Sequence[str]
) -> tuple[str, ...]:
    """A sentence on the held-out trial in which tied explanations differ most; none if all predict each alike.

    ``errors`` : of the held-out trials ``names``; ``labels`` : of the tied explanations in them, ``words`` in words.
    """
    counts = np.maximum(errors.counts.sum(axis=1), 1.0)
    rms = np.sqrt(np.array([errors.squares[label].sum(axis=1) / counts for label in labels]))
    noise = np.sqrt(errors.noise.sum(axis=1) / counts)
    worse = rms / np.maximum(rms.min(axis=0), noise)
    told = int(np.argmax(worse.max(axis=0)))
    if not worse[:, told].max() > CLEARLY_WORSE:
        return ()
    order = np.argsort(rms[:, told])
    shown = [*order[: MOST_EXPLANATIONS - 1], order[-1]] if len(order) > MOST_EXPLANATIONS else order
    each = ", ".join(f"{angle_text(Estimate(float(rms[k, told]), 'deg'))} with {words[k]}" for k in shown)
    return (
        decisive(
            f"held-out {names[told]} separates the tied explanations: its error is {each}. Held-out trials do not "
            "choose between explanations",
            f"Remove `held_out: true` from {names[told]} if it may count; then hold out another one.",
        ),
    )
