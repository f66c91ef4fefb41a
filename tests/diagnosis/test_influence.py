"""A single influential recording is named, with the verdict without it; consistent ones give no warning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, heavier, off, recorded, with_effects
from synth.diagnosis import influence
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.diagnosis_result import Verdict
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose, scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.verdict import CALIBRATED, Judgement, judge
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS))
FRICTION = {"hip": {"coulomb_friction": {"torque": 0.12}}}


def test_a_contradicting_recording_is_named() -> None:
    """Three of a leg that lacks nothing, one of the same leg whose encoder slipped meanwhile."""
    built = off(TWO, 3, 0.5)
    trials = recorded(built, seed=2)
    slipped = replace(trials[1], angles=trials[1].angles + np.array([0.0, 0.12]))
    result = diagnose(TWO, [trials[0], slipped, *trials[2:]], Tolerance())
    (warning,) = [text for text in result.warnings if "depends on" in text or "contradicts the others" in text]
    assert trials[1].name in warning


def test_a_recording_that_hides_a_cause_is_named() -> None:
    """Nothing explains four recordings of which one has a mass that is not told; friction explains the other three."""
    built = with_effects(off(TWO, 4, 0.5), FRICTION)
    trials = recorded(built, seed=2)
    loaded = recorded(heavier(built, "knee", 0.5), seed=2)[1]
    result = diagnose(TWO, [trials[0], loaded, *trials[2:]], Tolerance())
    assert result.verdict == "unknown"
    (warning,) = [text for text in result.warnings if "contradicts the others" in text]
    assert warning.startswith(f"{loaded.name} contradicts the others: with coulomb_friction (hip) their error is ")
    assert result.diagnosed == TWO  # numbers at the ends of their tolerances would be the next diagnosis' design


def test_consistent_recordings_give_no_influence_warning() -> None:
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), FRICTION), seed=2), Tolerance())
    assert result.verdict == "effect"
    assert not [text for text in result.warnings if "depends on" in text or "contradicts the others" in text]


def assessed_of(built: Leg, seeds: Sequence[int], effect: str) -> tuple[Workbench, Hypotheses[EvaluatedHypothesis]]:
    """The nominal leg and one cause at the hip, fitted to the trials of these seeds of noise."""
    trials = [trial for seed in seeds for trial in recorded(built, seed=seed, held_out=0)]
    named = [replace(trial, name=f"{k}.csv") for k, trial in enumerate(trials)]
    scene, _ = scene_of(TWO, named, Tolerance(), 0)
    cause = next(each for each in FOUND if each.key == (effect, "hip"))
    designed = as_designed(scene.bench)
    start = designed.beside([cause], [cause.starts()[0]])
    fits = refine(scene.bench, scene.bench.evaluate([designed, start]))
    none, single = (Assessment(fit, fit.cost, rms_over_noise(scene.bench, fit)) for fit in fits)
    return scene.bench, Hypotheses(none, (single,), ())


def test_only_some_recordings_are_refitted_without() -> None:
    """Where each recording seems to turn the verdict, a fit without each would take hours of two hundred."""
    bench, found = assessed_of(with_effects(off(TWO, 4), FRICTION), (0, 1), "coulomb_friction")
    assert len(bench.trials) == influence.MOST_REFITTED + 2
    other = replace(judge(found, CALIBRATED), verdict="unknown")  # what no recording's absence leaves
    hangs = influence.verdict_dependence(bench, found, other, CALIBRATED)
    assert len(hangs.turned) == influence.MOST_REFITTED
    assert all("coulomb_friction (hip)" in verdict for _, verdict in hangs.turned)
    assert sorted([*dict(hangs.turned), *hangs.open]) == [f"{k}.csv" for k in range(len(bench.trials))]


def test_several_pieces_of_a_recording_are_counted_not_listed() -> None:
    """The note listed each window of a recording that is compared in pieces: "trials/01.csv from 0.056 s, ..."."""
    first, second = TRIALS[:2]
    cuts = range(0, len(first.time), len(first.time) // 4)
    pieces = [first.piece(begin, begin + len(first.time) // 4) for begin in [*cuts][:4]]
    name = first.recording.name
    assert influence.names_of_pieces([*pieces, second], [0, 2, 3, 4]) == (
        f"3 of the 4 pieces of {name}",
        second.recording.name,
    )
    assert influence.names_of_pieces([*pieces, second], [1]) == (pieces[1].recording.name,)
    assert influence.names_of_pieces([first, second], [0, 1]) == (name, second.recording.name)


def test_an_accepted_cause_that_is_not_among_the_heaviest_is_asked_too() -> None:
    """What all tied sets share may be accepted without being among those that are evaluated again."""
    bench, found = assessed_of(with_effects(off(TWO, 4), FRICTION), (0,), "coulomb_friction")
    judged = judge(found, CALIBRATED)
    apart = replace(judged, verdict="effect", accepted=replace(found.singles[0]))
    assert id(apart.accepted) not in {id(item) for item, _ in judged.weighed}
    assert influence.verdict_dependence(bench, found, apart, CALIBRATED).odd == ()


def test_a_recording_that_alone_shows_a_further_cause_is_not_said_to_contradict() -> None:
    """Of two drives whose current is limited only the hardest steps showed the second limit: "check it first"."""
    bench, found = assessed_of(with_effects(off(TWO, 4), FRICTION), (2,), "coulomb_friction")
    slipped = replace(bench.trials[1], measured=bench.trials[1].measured + np.array([0.0, 0.12]))
    bench = replace(bench, trials=(bench.trials[0], slipped, *bench.trials[2:]))
    (fit,) = refine(bench, bench.evaluate([found.singles[0].fit.start_at()]))
    single = Assessment(fit, fit.cost, rms_over_noise(bench, fit))
    (alone,) = influence._odd_recording(bench, [(single, None)], ())
    assert alone.text.startswith(f"{slipped.recording.name} contradicts the others: with coulomb_friction (hip) their ")
    knee = next(each for each in FOUND if each.key == ("latency", "knee"))
    for ratio, told in ((alone.left, "with latency (knee) too it is 1 times"), (1.5 * alone.left, "Check it first")):
        both = Assessment(fit.beside([knee], [knee.starts()[0]]), fit.cost, ratio)
        (odd,) = influence._odd_recording(bench, [(single, None)], (both,))
        assert told in odd.text, odd.text


def test_causes_of_a_set_are_weighed_beside_their_parts() -> None:
    """A third cause that imitates both leads; without each of theirs alone they seem to take nothing beside it."""
    _, found = assessed_of(with_effects(off(TWO, 4), FRICTION), (0,), "coulomb_friction")
    friction = found.singles[0]
    parts = [replace(friction, fit=cause_alone(friction, key)) for key in (("latency", "hip"), ("latency", "knee"))]
    both = replace(friction, fit=cause_alone(friction, *(item.fit.keys[0] for item in parts)))
    every = replace(found, singles=(friction, *parts), several=(both,))
    only = Judgement("effect", both, (), (), 0.0, 0.0, ((both, 1.0),))
    asked = influence._asked_again(every, only)
    assert [item.keys for item in asked].count(both.keys) == 1
    assert {item.keys for item in asked} == {(), friction.keys, both.keys, *(item.keys for item in parts)}


def cause_alone(like: Assessment[EvaluatedHypothesis], *keys: tuple[str, str]) -> EvaluatedHypothesis:
    """The designed leg with these causes at their starts."""
    causes = [each for key in keys for each in FOUND if each.key == key]
    return replace(like.fit, hypothesis=()).beside(causes, [each.starts()[0] for each in causes])


def test_one_step_without_a_recording_determines_a_shape_as_a_fit_without_it() -> None:
    """One of four slipped: without it the residuals are small, and the shape is determined far better."""
    built = with_effects(off(TWO, 4), {"hip": {"quadratic_damping": {"coefficient": 0.05}}})
    bench, found = assessed_of(built, (2,), "quadratic_damping")
    slipped = replace(bench.trials[1], measured=bench.trials[1].measured + np.array([0.0, 0.12]))
    bench = replace(bench, trials=(bench.trials[0], slipped, *bench.trials[2:]))
    (fit,) = refine(bench, bench.evaluate([found.singles[0].fit.start_at()]))
    single = Assessment(fit, fit.cost, rms_over_noise(bench, fit))
    stepped = influence._step_without_each(bench, single)[1]
    (refitted,) = influence._refit_without(bench, [stepped], 1)
    assert stepped.fit.shapes[:, 1] == pytest.approx(refitted.fit.shapes[:, 1], rel=0.5)
    assert stepped.fit.shapes[:, 1] > 5.0 * fit.shapes[:, 1]
    assert not stepped.fit.start.residuals  # nothing that was computed elsewhere


def test_a_verdict_that_hangs_on_a_recording_is_less_sure() -> None:
    """One of three: (1 + 1/2) / (3 + 1); a recording without which a further cause is missing leaves the first sure."""
    assert influence.VerdictDependence((("a.csv", "none"),), of=3, against=1).chance == pytest.approx(0.375)
    assert influence.VerdictDependence((("a.csv", "hip alone"),), of=3, against=0).chance == 0.0
    assert influence.VerdictDependence(of=3).chance == 0.0


def test_naming_some_of_the_causes_does_not_contradict_a_verdict() -> None:
    def judged(verdict: Verdict, *effects: str) -> Judgement[EvaluatedHypothesis]:
        causes = tuple(next(each for each in FOUND if each.key == (name, "hip")) for name in effects)
        fit = EvaluatedHypothesis(causes, np.zeros(sum(cause.size for cause in causes)), ())
        return Judgement(verdict, Assessment(fit, 1.0, 1.0), (), (), 0.0, 0.0)

    both = judged("effect", "coulomb_friction", "encoder_offset")
    assert influence._shares_a_cause(both, judged("effect", "coulomb_friction"))
    assert not influence._shares_a_cause(both, judged("effect", "quadratic_damping"))
    assert not influence._shares_a_cause(both, judged("unknown", "coulomb_friction"))
    assert not influence._shares_a_cause(both, judged("none"))
