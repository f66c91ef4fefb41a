"""Logs that begin in the middle of a motion: what a servo's integral has summed up by then is not known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_servos import ARM, NOISE, driven
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.score import first_state
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import INTEGRAL_LIMIT, Servo
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.integral_starts import held_integrals, usual_departures
from synth.swing.leg_model import Leg, Tip
from synth.swing.tolerances import Tolerances

CUT = 130  # samples, 0.65 s


def with_integral(period: float = 0.0) -> Leg:
    servo = ARM.joints[0].drive
    assert isinstance(servo, Servo)
    return ARM.with_joints(knee={"drive": replace(servo, integral_gain=3.0, control_period=period)})


def late(trial: Trial) -> Trial:
    signals = trial.signals
    assert signals is not None
    time = trial.time[CUT:] - trial.time[CUT]
    rest = {name: getattr(signals, name)[CUT:] for name in ("command", "supply", "enabled")}
    return replace(trial, time=time, angles=trial.angles[CUT:], signals=replace(signals, time=time, **rest))


def bench_of(leg: Leg) -> Workbench:
    read = recordings(leg, [late(trial) for trial in driven(leg)], ())
    trials = tuple(angle_trial(recording, held_out=False) for recording in read)
    return Workbench(Predictor(leg, Tolerances.of(leg, Tolerance())), trials, np.array([NOISE]), 50.0)


@pytest.mark.parametrize("period", [0.0, 0.01], ids=["continuous", "in control steps"])
def test_a_healthy_servo_is_followed_from_the_middle_of_its_motion(period: float) -> None:
    """From the sum that only holds the first angle the nominal leg stays 59 to 181 times the noise off."""
    bench = bench_of(with_integral(period))
    start = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), tuple(first_state(trial) for trial in bench.trials))
    found = bench.awake(start)
    for _ in range(5):
        (found,) = bench.solve([found], bench.frame(found), 8)
    for trial, residual in zip(bench.trials, found.residuals, strict=True):
        white = residual[: len(trial.time)] * bench.tempering(trial)[0]
        assert np.mean(white**2) < 1.1


def test_a_sum_is_a_state_of_its_own_between_those_of_joints_and_links() -> None:
    """Its unit comes from the gains, and it acts alike beside a mount that yields; zero is the sum that holds."""
    leg = with_integral()
    bench = bench_of(leg)
    trial = bench.trials[0]
    found = candidates(leg, bench.trials, natural_sizes_of(leg, bench.trials))
    mount = next(c for c in found if c.key == ("base_compliance", "base"))
    unknowns = np.concatenate([np.zeros(bench.n_tolerance), mount.starts()[0]])
    awake = bench.awake(EvaluatedHypothesis((mount,), unknowns, (first_state(trial),)))
    assert len(awake.states[0]) == 2 + 1 + 2
    signals = trial.recording.signals
    assert signals is not None
    held = held_integrals(leg, Tip(), 0.0, first_state(trial)[:1], signals.supply[0])[0]
    (unit,) = usual_departures(leg).values()
    assert unit == leg.joints[0].drive.numbers[INTEGRAL_LIMIT]  # type: ignore[union-attr]
    moved = awake.states[0].copy()
    moved[2] = -held / unit  # no sum at all
    for item, given, state in (((), unknowns[: bench.n_tolerance], moved[:3]), ((mount,), unknowns, moved)):
        without, holding = (
            bench.predictor.predict([trial], [Block(item, given[:, None], each[None, :, None])])[0][:, 0, 0]
            for each in (state, np.where(np.arange(len(state)) == 2, 0.0, state))
        )
        # The load, which no sum carries now, pulls towards straight down.
        assert (without - holding)[20] * np.sign(first_state(trial)[0]) < -np.radians(0.2)
