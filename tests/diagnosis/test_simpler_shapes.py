"""A cause keeps the shape that its unknowns are worth: gear friction whose fall with speed is there, or not."""

from __future__ import annotations

import numpy as np
import pytest

from synth.diagnosis.angle_search import as_recorded
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.simpler_shapes import prefer_simpler_shapes
from synth.diagnosis.workbench import Workbench
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

SERVO = Servo(gain=2.0, supply=7.4, motor=GearedMotor(3.5, 0.37, 1.0, 1.0, 2e-3))
LEG = Leg("arm", (Joint("arm", Link(0.12, 0.49, 0.1, 1e-4), drive=SERVO),))
TIME = np.arange(0.0, 1.5, 0.005)
NOISE = 5e-5  # rad
RICH = ("share", "torque", "fall", "speed")


def logs(fall: float) -> tuple[Workbench, list[Candidate]]:
    """Three logs of an arm whose gear rubs by a share of its torque, less by ``fall`` at speed; its candidates."""
    friction = {"share": 0.3, "torque": 0.02, "fall": fall, "speed": 1.5}
    built, rng = LEG.with_joints(arm={"effects": {"gear_friction": friction}}), np.random.default_rng(2)
    ones, trials = np.ones((len(TIME), 1)), []
    for k, pace in enumerate((0.7, 1.3, 2.1)):
        command = 0.8 * np.sin(2.0 * np.pi * pace * TIME)[:, None]
        signals = ServoSignals(TIME, command, 7.4 * ones, ones, (0,))
        angles = simulate(built, [0.0], [0.0], TIME, signals=signals)
        trials.append(Trial(f"{k}.csv", TIME, angles + NOISE * rng.standard_normal(angles.shape), signals=signals))
    scene, _ = scene_of(LEG, trials, Tolerance(), 0, {"arm": NOISE})
    return scene.bench, candidates(LEG, scene.given, natural_sizes_of(LEG, scene.given))


def rich_fit(bench: Workbench, found: list[Candidate]) -> EvaluatedHypothesis:
    """The shape with a fall, fitted with its own derivatives."""
    shape = next(each for each in found if each.effect.name == "gear_friction" and each.shape.free == RICH)
    begun = as_recorded(bench)
    unknowns = np.concatenate([begun.unknowns, shape.starts()[0]])
    return refine(bench, bench.evaluate([EvaluatedHypothesis((shape,), unknowns, begun.states)]))[0]


@pytest.mark.parametrize(("fall", "kept"), [(0.0, ("share", "torque")), (0.7, RICH)])
def test_unknowns_that_explain_nothing_are_dropped(fall: float, kept: tuple[str, ...]) -> None:
    bench, found = logs(fall)
    fit = rich_fit(bench, found)
    (made,) = prefer_simpler_shapes(bench, [fit], found, CALIBRATED.per_parameter)
    assert made.hypothesis[0].shape.free == kept
    assert made.cost - fit.cost <= CALIBRATED.per_parameter * (len(RICH) - len(kept))
    assert made.hypothesis[0].named(made.unknowns[bench.n_tolerance :])["share"] == pytest.approx(0.3, rel=0.1)
