"""The step that readings are rounded to: an encoder's count, or the last digit of a file."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array

COARSE_NOISE = 0.6  # noise over count, below which rounding is no longer like noise (see ``fit.rounding``)
LEAST_GAP = 1e-7  # rad between readings; less is how a file is written
SURE_COUNTS = 10.0  # counts from one level to the next, whose number a width known to a few per cent tells
SHARE_ON_GRID = 0.98  # share of the readings that must lie on the counts


def width_of(gaps: Array, least: float) -> float:
    """Width of a count in rad, if readings with these gaps (m,) from one level to the next are counts; 0 without any.

    Text files round each reading, at 20 rad to a hundredth of a count. So the width is that of all gaps together, over
    the number of counts in them, of which those of a few counts are sure. ``least`` : gap in rad that may be a count.
    """
    gaps = gaps[gaps > least]
    if not len(gaps):
        return 0.0
    width = float(gaps.min())
    width = float(np.mean(gaps[gaps < 1.5 * width]))
    sure = gaps[gaps < SURE_COUNTS * width]
    return float(sure.sum() / np.round(sure / width).sum())


def on_counts(values: Array, width: float) -> bool:
    """Whether nearly all readings (m,) rad differ from the first by whole counts of this ``width``, rad."""
    rest = (values - values[0]) / width
    # 2 % of a count, and 1e-5 per count for a width that is known to five digits.
    return bool(np.mean(np.abs(rest - np.round(rest)) < 0.02 + 1e-5 * np.abs(rest)) > SHARE_ON_GRID)


def coarse_count(readings: Array, noise: float) -> float:
    """Width of one count, rad, of readings (m,) rad if it is coarse against their ``noise``, rad; else 0."""
    width = width_of(np.diff(np.unique(readings)), LEAST_GAP)
    return width if width > 0.0 and noise < COARSE_NOISE * width and on_counts(readings, width) else 0.0
