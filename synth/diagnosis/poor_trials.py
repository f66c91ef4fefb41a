"""Scored trials that an explanation predicts no better than the nominal leg, and why."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.prediction_error import NO_BETTER_RATIO, PredictionErrors

LEFT_OPEN_WORDS = (
    "the training trials do not determine what matters there (a tip mass shows the leg's total mass and lengths, a "
    "tilt its gravity)"
)


def poor_trials(errors: PredictionErrors) -> NDArray[np.bool_]:
    """(n_trial,) which scored trials the explanation predicts no better than the nominal leg."""
    return np.asarray(_squared(errors, "after") > NO_BETTER_RATIO * _squared(errors, "before"))


def followed_trials(errors: PredictionErrors, moved: PredictionErrors) -> NDArray[np.bool_]:
    """(n_trial,) which ``poor_trials`` the explanation predicts better once moved within its uncertainty."""
    return np.asarray(poor_trials(errors) & (_squared(moved, "after") < _squared(errors, "before")))


def _squared(errors: PredictionErrors, label: str) -> Array:
    """(n_trial,) summed squared errors, rad^2."""
    return np.asarray(errors.squares[label].sum(axis=1))


def no_better(
    names: Sequence[str], errors: PredictionErrors, moved: PredictionErrors | None, words: str = "the explanation"
) -> list[str]:
    """Texts on the scored trials that the explanation predicts no better than the nominal leg.

    ``moved`` : the errors of the explanation moved to held-out trials within its uncertainty, if known; ``words`` :
    for the explanation.
    """
    poor = poor_trials(errors)
    followed = np.zeros_like(poor) if moved is None else followed_trials(errors, moved)
    asked = "add a training trial of that kind"
    found = []
    for which, reason in (
        (followed, f", but better once its numbers move within the tolerances: {LEFT_OPEN_WORDS}; {asked}"),
        (poor & ~followed, f". Either {LEFT_OPEN_WORDS}, or another effect is present; {asked}"),
    ):
        shown = ", ".join(name for name, is_shown in zip(names, which, strict=True) if is_shown)
        found += [f"{shown}: predicted no better with {words} than without{reason}"] if shown else []
    return found
