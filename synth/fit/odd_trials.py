"""Trials that stand out from the others of a fit: named, since one wrong recording bends the estimates of all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array

LEAST = 3  # trials among which one can stand out
TIMES = 4.0  # the others' usual size
LEAST_RMS = np.radians(1.0)  # a smaller misfit changes no estimate noticeably
LEAST_SHIFT = np.radians(10.0)  # of a free angle; limbs do shift by some degrees from trial to trial
LOOK = "look at it first: exchanged columns, another unit or clock, a joint that was held or touched"


def odd_trials(names: Sequence[str], joints: Sequence[str], rms: Array, free_angle: Array | None = None) -> list[str]:
    """Sentences on trials whose misfit, or whose free angle, is far from that of all others.

    Parameters
    ----------
    rms : (n_trial, n) rad, nan for a locked joint; free_angle : (n_trial, n) rad of each trial, None where common.
    """
    if len(names) < LEAST:
        return []
    said = []
    for i, name in enumerate(names):
        others = [k for k in range(len(names)) if k != i]
        for j, joint in enumerate(joints):
            usual = _median(rms[others, j])
            if rms[i, j] > max(TIMES * usual, LEAST_RMS):
                off, rest = np.degrees(rms[i, j]), np.degrees(usual)
                said.append(
                    f"{name}: {joint} is {off:.2g} deg (RMS) off there and {rest:.2g} deg in the others; {LOOK}"
                )
                break
            if free_angle is None:
                continue
            middle = _median(free_angle[others, j])
            spread = _median(np.abs(free_angle[others, j] - middle))
            if abs(free_angle[i, j] - middle) > max(TIMES * 1.4826 * spread, LEAST_SHIFT):
                there, rest = np.degrees(free_angle[i, j]), np.degrees(middle)
                away = f"would have its free angle at {there:.3g} deg there and at {rest:.3g} deg in the others"
                said.append(f"{name}: {joint} {away}; {LOOK}")
                break
    return said


def _median(values: Array) -> float:
    good = values[np.isfinite(values)]
    return float(np.median(good)) if len(good) else np.nan
