"""A series of recordings with an external torque: all are cut at the longest detected one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from synth.files.import_project import ForeignFile
from synth.motion.importers.convert import ImportedRecording
from synth.motion.importers.import_result import ImportedTrial, _without_hand
from synth.motion.release import FADING, Release, free_after

TIME = np.arange(0.0, 1.0, 0.01)


def trial(name: str, release: Release | None, window: tuple[float, float] | None = None) -> ImportedTrial:
    start = 0.0 if release is None else release.free_from
    kept = TIME[start - 1e-9 <= TIME]
    made = ImportedRecording("csv", kept, np.zeros((len(kept), 1)), len(TIME), release, (), None)
    return ImportedTrial(ForeignFile(Path(name), name, window), f"trials/{name}", made)


def released(at: float | None, until: float | None) -> Release:
    start = 0.0 if at is None else at
    return Release(at, start if until is None else until, until, "")


def test_the_longest_external_torque_counts_for_all_recordings() -> None:
    made = _without_hand(
        [
            trial("a.csv", released(0.20, 0.30)),
            trial("b.csv", released(None, 0.14)),  # begins in motion
            trial("c.csv", released(0.40, None)),  # none seen
            trial("d.csv", released(0.10, None), window=(0.1, 0.9)),  # picked by hand
        ]
    )
    longest = 0.14 + FADING
    assert free_after([0.10, 0.14]) == pytest.approx(longest)
    starts = [item.imported.time[0] for item in made]
    np.testing.assert_allclose(starts, [0.37, 0.17, 0.57, 0.10], atol=0.0051)
    assert [len(item.imported.notes) for item in made] == [1, 1, 1, 0]
    assert "detected in 2 of 3 recordings" in made[2].imported.notes[0]


def test_an_external_torque_far_longer_than_the_others_is_ignored() -> None:
    assert free_after([0.11, 0.12, 0.10, 0.12, 0.75, 0.79]) == pytest.approx(1.3 * 0.12 + FADING)
    assert free_after([0.75]) == pytest.approx(0.78)


def test_nothing_is_cut_without_external_torque_or_if_nothing_would_remain() -> None:
    none = [trial("a.csv", released(0.2, None)), trial("b.csv", None)]
    assert _without_hand(none) == none
    alike = trial("a.csv", replace(released(0.2, 0.3), free_from=0.2))  # a hand and another law look alike
    assert _without_hand([alike]) == [alike]
    short = [trial("a.csv", released(None, 0.2)), trial("b.csv", released(0.75, None))]
    assert [item.imported.time[0] for item in _without_hand(short)] == pytest.approx([0.23, 0.75])
