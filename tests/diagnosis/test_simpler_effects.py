"""A cause that is a simpler one under another name is no rival of it; one that explains more stays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, recorded, with_effects
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.settled import settle_leading
from synth.files.gap_project import Tolerance
from synth.swing.effects import registered
from synth.swing.leg_model import Leg, Spring

NOISE = np.radians(0.05)


def settled(built: Leg, free: tuple[str, str]) -> list[str]:
    """Of another spring rate and a hardening that frees these, fitted to releases: those among the hypotheses."""
    trials = recorded(built, noise=NOISE)
    scene, _ = scene_of(ONE, trials, Tolerance(), 0, {"knee": NOISE})
    bench, designed = scene.bench, as_designed(scene.bench)
    every = candidates(ONE, scene.given, natural_sizes_of(ONE, scene.given))
    chosen = [c for c in every if c.effect.name == "spring_rate"]
    chosen += [c for c in every if c.effect.name == "hardening_spring" and c.shape.free == free]
    assert len(chosen) == 2
    starts = [
        EvaluatedHypothesis((c,), np.concatenate([designed.unknowns, c.starts()[0]]), designed.states) for c in chosen
    ]
    fits = [designed, *refine(bench, bench.evaluate(starts), 20)]
    none, *singles = [Assessment(fit, fit.cost, rms_over_noise(bench, fit)) for fit in fits]
    ends, _ = settle_leading(bench, Hypotheses(none, tuple(singles), ()), CALIBRATED)
    return sorted(single.keys[0][0] for single in ends.singles)


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
