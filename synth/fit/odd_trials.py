"""Trials that differ from the others of a fit: they are named, because one wrong recording biases all estimates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array, finite_median
from synth.noise import MAD_TO_SD
from synth.units import significant

LEAST_TRIALS = 3  # trials needed to identify a different one
ODD_RATIO = 4.0  # times the others' usual value
LEAST_RMS = np.radians(1.0)  # a smaller misfit hardly changes any estimate
LEAST_SHIFT = np.radians(10.0)  # of a free angle; limbs shift by some degrees between trials
CHECKS_FIRST = "check it first for exchanged columns, another unit or clock, a joint that was held or touched"


def odd_trials(names: Sequence[str], joints: Sequence[str], rms: Array, free_angle: Array | None = None) -> list[str]:
    """Sentences on trials whose misfit, or whose free angle, differs strongly from the others.

    Parameters
    ----------
    rms : (n_trial, n) rad, nan for a locked joint; free_angle : (n_trial, n) rad of each trial, nan where it is not of
        the trial's own (common, locked, of no spring), None for none.
    """
    if len(names) < LEAST_TRIALS:
        return []
    messages = []
    for i, name in enumerate(names):
        others = [k for k in range(len(names)) if k != i]
        for j, joint in enumerate(joints):
            usual = finite_median(rms[others, j])
            if rms[i, j] > max(ODD_RATIO * usual, LEAST_RMS):
                off, rest = np.degrees(rms[i, j]), np.degrees(usual)
                messages.append(
                    f"{name}: {joint} is {significant(off, 2)} deg RMS there and "
                    f"{significant(rest, 2)} deg in the others; {CHECKS_FIRST}"
                )
                break
            if free_angle is None:
                continue
            middle = finite_median(free_angle[others, j])
            spread = MAD_TO_SD * finite_median(np.abs(free_angle[others, j] - middle))
            if abs(free_angle[i, j] - middle) > max(ODD_RATIO * spread, LEAST_SHIFT):
                there, rest = np.degrees(free_angle[i, j]), np.degrees(middle)
                away = f"would have its free angle at {there:.3g} deg there and at {rest:.3g} deg in the others"
                messages.append(f"{name}: {joint} {away}; {CHECKS_FIRST}")
                break
    return messages
