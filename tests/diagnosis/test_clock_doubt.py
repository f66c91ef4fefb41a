"""A clock that runs wrong is told beside causes that stand for it, and not where they explain the recordings better."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pytest

from diagnosis.simulated_servos import ARM, driven
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.clock_doubt import clock_warnings, with_clock
from synth.diagnosis.restarts import refine
from synth.diagnosis.verdict import CALIBRATED, judge
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.leg_model import Leg


def warnings(trials: list[Trial], effect: str, leg: Leg = ARM) -> tuple[str, ...]:
    """Of the designed leg and one cause at the knee, of which the cause is accepted."""

    def bench_of(made: Sequence[Trial]) -> Workbench:
        return scene_of(leg, made, Tolerance(), 0)[0].bench

    scene, _ = scene_of(leg, trials, Tolerance(), 0)
    every = candidates(leg, scene.given, natural_sizes_of(leg, scene.given))
    cause = next(each for each in every if each.key == (effect, "knee"))
    designed = as_designed(scene.bench)
    fits = refine(scene.bench, scene.bench.evaluate([designed, designed.beside([cause], [cause.starts()[0]])]))
    none, single = (Assessment(fit, fit.cost, rms_over_noise(scene.bench, fit)) for fit in fits)
    found = Hypotheses(none, (single,), ())
    return clock_warnings(leg, found, judge(found, CALIBRATED), trials, bench_of)


@pytest.mark.parametrize(("factor", "word"), [(0.97, "slow"), (1.03, "fast")])
def test_a_wrong_clock_is_told(factor: float, word: str) -> None:
    """A log 3 % short got two or three causes that are not there."""
    recorded = [with_clock(trial, factor) for trial in driven(ARM, 2)]
    (text,) = warnings(recorded, "viscous_damping")
    told = re.match(
        rf"a clock of the recordings that is ([\d.]+) % {word} explains them as well without any cause", text
    )
    assert told is not None, text
    assert float(told[1]) == pytest.approx(100.0 * abs(1.0 / factor - 1.0), abs=0.1)


def test_a_right_clock_is_not_doubted() -> None:
    stiff = ARM.with_joints(knee={"effects": {"coulomb_friction": {"torque": 0.05}}})
    assert warnings(driven(stiff, 2), "coulomb_friction") == ()
    assert warnings(driven(stiff, 2), "viscous_damping") == ()  # a cause that leaves much, and no clock leaves less
