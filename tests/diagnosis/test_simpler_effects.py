"""A cause that is a simpler one under another name is no rival of it; one that explains more stays."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from diagnosis.simulated_releases import HANGING, ONE, recorded, with_effects
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.settled import settle_leading
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.effects import registered
from synth.swing.leg_model import Leg, Spring

NOISE = np.radians(0.05)


def fitted(
    leg: Leg, trials: list[Trial], chosen: Callable[[Candidate], bool]
) -> tuple[Workbench, list[Assessment[EvaluatedHypothesis]]]:
    """The designed leg fitted to releases, then with each of the chosen causes from its first start."""
    scene, _ = scene_of(leg, trials, Tolerance(), 0, {"knee": NOISE})
    bench, designed = scene.bench, as_designed(scene.bench)
    every = [c for c in candidates(leg, scene.given, natural_sizes_of(leg, scene.given)) if chosen(c)]
    starts = [
        EvaluatedHypothesis((c,), np.concatenate([designed.unknowns, start]), designed.states)
        for c in every
        for start in c.starts()
    ]
    fits = [designed, *refine(bench, bench.evaluate(starts), 20)]
    return bench, [Assessment(fit, fit.cost, rms_over_noise(bench, fit)) for fit in fits]


def settled(built: Leg, free: tuple[str, str]) -> list[str]:
    """Of another spring rate and a hardening that frees these, fitted to releases: those among the hypotheses."""
    bench, (none, *singles) = fitted(
        ONE,
        recorded(built, noise=NOISE),
        lambda c: c.effect.name == "spring_rate" or (c.effect.name == "hardening_spring" and c.shape.free == free),
    )
    best = {single.keys: single for single in sorted(singles, key=lambda single: -single.cost)}
    assert len(best) == 2
    ends, _ = settle_leading(bench, Hypotheses(none, tuple(best.values()), ()), CALIBRATED)
    return sorted(single.keys[0][0] for single in ends.singles)


def test_a_stop_is_no_spring_that_hardens() -> None:
    """Pressed on it on one side alone the torques are the same; a spring of fifteen times its rate is none."""
    bent = HANGING.with_joints(knee={"spring": Spring(0.4, 1.0)})  # gravity holds it on one side of its free angle
    leg = with_effects(bent, {"knee": {"joint_stop": {"upper": 1.6, "stiffness": 6.0}}})
    away = np.array([[0.0], [-0.1], [0.1], [-0.2]])
    chosen = ("joint_stop", "hardening_spring")
    _, (_, *singles) = fitted(bent, recorded(leg, away, noise=NOISE), lambda c: c.effect.name in chosen)
    left = {name: min(single.ratio for single in singles if single.keys[0][0] == name) for name in chosen}
    assert left["joint_stop"] < 1.1 < 3.0 < left["hardening_spring"]


@pytest.mark.parametrize("rate", [1.05, 2.25])  # N m/rad, 1.5 designed
@pytest.mark.parametrize("free", [("stiffening", "onset"), ("stiffening", "exponent")])
def test_a_hardening_that_is_a_spring_rate_is_no_rival_of_it(rate: float, free: tuple[str, str]) -> None:
    built = ONE.with_joints(knee={"spring": Spring(rate, 1.8)})
    assert settled(built, free) == ["spring_rate"]


@pytest.mark.parametrize(
    ("built", "free"),
    [
        ({"stiffening": 0.8, "exponent": 1.0, "onset": 0.25}, ("stiffening", "onset")),
        ({"stiffening": 0.8, "exponent": 1.0, "onset": 0.04}, ("stiffening", "onset")),
        ({"stiffening": 0.8, "exponent": 1.2}, ("stiffening", "exponent")),
        ({"stiffening": -0.5, "exponent": 3.0}, ("stiffening", "exponent")),
    ],
)
def test_a_real_hardening_stays(built: Mapping[str, float], free: tuple[str, str]) -> None:
    leg = with_effects(ONE, {"knee": {"hardening_spring": built}})
    assert settled(leg, free) == ["hardening_spring", "spring_rate"]


def test_what_an_effect_becomes_is_an_effect_with_fewer_parameters() -> None:
    known = {effect.name: effect for effect in registered()}
    said = [(effect, simpler) for effect in known.values() for simpler in effect.becomes]
    assert said
    for effect, simpler in said:
        assert {*simpler.where} <= {parameter.name for parameter in effect.parameters}
        assert len(known[simpler.name].parameters) < len(effect.parameters)
