"""A single influential recording is named, with the verdict without it; consistent ones give no warning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, off, recorded, with_effects
from synth.diagnosis import influence
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.diagnosis_result import Verdict
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessed
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, scales
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.verdict import Judged
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, scales(TWO, TRIALS))
FRICTION = {"hip": {"coulomb_friction": {"torque": 0.12}}}


def test_a_contradicting_recording_is_named() -> None:
    """Three of a leg that lacks nothing, one of the same leg whose encoder slipped meanwhile."""
    built = off(TWO, 3, 0.5)
    trials = recorded(built, seed=2)
    slipped = replace(trials[1], angles=trials[1].angles + np.array([0.0, 0.12]))
    result = diagnose(TWO, [trials[0], slipped, *trials[2:]], Tolerance())
    (warning,) = [text for text in result.warnings if "depends on" in text or "contradicts the others" in text]
    assert trials[1].name in warning


def test_consistent_recordings_give_no_influence_warning() -> None:
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), FRICTION), seed=2), Tolerance())
    assert result.verdict == "effect"
    assert not [text for text in result.warnings if "depends on" in text or "contradicts the others" in text]


def test_only_the_most_influential_recordings_are_refitted_without(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where each recording seems to turn the verdict, a fit without each would take hours of two hundred."""
    refits: list[int] = []

    def refitted(bench: Workbench, found: Sequence[Assessed], out: int) -> list[Assessed]:
        refits.append(out)
        return list(found)

    monkeypatch.setattr(influence, "_refitted", refitted)
    monkeypatch.setattr(influence, "_differs", lambda judged, again: True)
    built = with_effects(off(TWO, 4), FRICTION)
    trials = [trial for seed in range(3) for trial in recorded(built, seed=seed)]
    assert len(trials) > 2 * influence.MOST_REFITTED - 1
    named = [replace(trial, name=f"{k}.csv") for k, trial in enumerate(trials)]
    result = diagnose(TWO, named, Tolerance())
    assert len(refits) == influence.MOST_REFITTED
    (open_,) = [text for text in result.warnings if "may also depend on" in text]
    assert all(f"{out}.csv" not in open_.replace(",", " ").split() for out in refits)


def test_a_verdict_that_hangs_on_a_recording_is_less_sure() -> None:
    """One of three: (1 + 1/2) / (3 + 1); a recording without which a further cause is missing leaves the first sure."""
    assert influence.Hangs((("a.csv", "none"),), of=3, against=1).chance == pytest.approx(0.375)
    assert influence.Hangs((("a.csv", "hip alone"),), of=3, against=0).chance == 0.0
    assert influence.Hangs(of=3).chance == 0.0


def test_naming_some_of_the_causes_does_not_contradict_a_verdict() -> None:
    def judged(verdict: Verdict, *effects: str) -> Judged[EvaluatedHypothesis]:
        causes = tuple(next(each for each in FOUND if each.key == (name, "hip")) for name in effects)
        fit = EvaluatedHypothesis(causes, np.zeros(sum(cause.size for cause in causes)), ())
        return Judged(verdict, Assessed(fit, 1.0, 1.0), (), (), 0.0, 0.0)

    both = judged("effect", "coulomb_friction", "encoder_offset")
    assert influence._shares_a_cause(both, judged("effect", "coulomb_friction"))
    assert not influence._shares_a_cause(both, judged("effect", "quadratic_damping"))
    assert not influence._shares_a_cause(both, judged("unknown", "coulomb_friction"))
    assert not influence._shares_a_cause(both, judged("none"))
