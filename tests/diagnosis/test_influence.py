"""One recording that decides: it is named, with what would be said without it; none where all say the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.swung import TWO, off, recorded, with_effects
from synth.diagnosis.diagnose import diagnose
from synth.files.gap_project import Tolerance

FRICTION = {"hip": {"coulomb_friction": {"torque": 0.12}}}


def test_a_single_recording_that_speaks_against_the_others_is_named() -> None:
    """Three of a leg that lacks nothing, one of the same leg whose encoder slipped meanwhile."""
    built = off(TWO, 3, 0.5)
    trials = recorded(built, seed=2)
    slipped = replace(trials[1], angles=trials[1].angles + np.array([0.0, 0.12]))
    result = diagnose(TWO, [trials[0], slipped, *trials[2:]], Tolerance())
    assert result.verdict != "none"
    (warning,) = [text for text in result.warnings if "hangs on" in text]
    assert trials[1].name in warning
    assert "nothing would be missing" in warning


def test_where_all_recordings_say_the_same_none_is_named() -> None:
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), FRICTION), seed=2), Tolerance())
    assert result.verdict == "effect"
    assert not [text for text in result.warnings if "hangs on" in text]
