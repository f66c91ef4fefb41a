"""Filtered recordings of free motion without the parts that the filter smears.

A filter that ran over the readings rounds off the corners at the release and at the end. No effect of a leg does so:
of a leg as designed, behind a filter of 20 Hz, an error of 0.1 deg remained for which a moving base was the nearest
cause. What a filter makes of the motion between is mostly a scale of each swing, which the initial states take up.
"""

from __future__ import annotations

from collections.abc import Sequence

from synth.fit.behind_filter import clear_of, seen_filter
from synth.fit.filtered_readings import REMEDY
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import Recording
from synth.remarks import Remark
from synth.swing.leg_model import Leg


def without_smeared_ends(leg: Leg, recordings: Sequence[Recording]) -> tuple[list[Recording], list[str]]:
    """The recordings without what a filter smears of their ends, and a remark; as they are if they show none."""
    seen = seen_filter(leg, recordings, LegFitOptions(free_angle="per_trial"))
    if seen is None:
        return list(recordings), []
    cut, reach = clear_of(recordings, seen)
    text = seen.words
    if reach:
        text += f": the first and last {1e3 * reach:.0f} ms of each recording, which it smears, are left out"
    return cut, [Remark(text, "note", REMEDY)]
