"""Suggested commands stay within their limits."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis.simulated_servos import ARM, driven
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain import command_menu
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.chain_menu import forecast, menu
from synth.diagnosis.plants.swinging_chain.command_menu import CommandLimits, CommandMenu, settled_state
from synth.diagnosis.plants.swinging_chain.command_programme import Programme
from synth.diagnosis.plants.swinging_chain.command_shapes import COMMAND_RATE, shapes
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo
from synth.files.tolerance import Tolerance
from synth.swing.leg_model import Joint, Leg, Link, Spring

LENGTH = 6.0  # s


@pytest.mark.parametrize("what", list(shapes(LENGTH)))
@pytest.mark.parametrize("speed", [0.8, 6.0])
def test_no_shape_leaves_the_range_or_is_too_fast(what: str, speed: float) -> None:
    limits = CommandLimits(np.array([-0.4]), np.array([1.0]), np.array([speed]), np.array([np.inf]))
    time = np.arange(0.0, LENGTH, 1.0 / COMMAND_RATE)
    command = limits.shaped(shapes(LENGTH)[what], time)
    assert command.min() >= -0.4 - 1e-12
    assert command.max() <= 1.0 + 1e-12
    assert np.abs(np.diff(command, axis=0)).max() * COMMAND_RATE <= speed * (1.0 + 1e-9)
    assert np.ptp(command) > 0.1 * 1.4  # and it moves


def test_a_programme_takes_its_levels_and_its_variations_are_neighbours() -> None:
    levels, dwell = np.array([[0.5], [-0.5], [0.0]]), np.ones((3, 1))
    stepped = np.array([[True], [True], [False]])
    plain = Programme(levels, dwell, stepped)
    time = np.arange(0.0, 3.0 + 1e-9, 0.01)
    made = plain.shape(time)[:, 0]
    np.testing.assert_allclose(made[time < 0.99], 0.5)
    np.testing.assert_allclose(made[(time > 1.01) & (time < 1.99)], -0.5)
    assert made[np.argmin(np.abs(time - 2.5))] == pytest.approx(-0.25)  # half way up the ramp
    rng = np.random.default_rng(1)
    near = [np.abs(plain.varied(rng).shape(time)[:, 0] - made).mean() for _ in range(50)]
    far = [np.abs(Programme.drawn(rng, 1, 3.0).shape(time)[:, 0] - made).mean() for _ in range(50)]
    assert 0.0 < np.mean(near) < 0.7 * np.mean(far)
    assert all(np.abs(Programme.drawn(rng, 2, 3.0).shape(time)).max() <= 1.0 for _ in range(50))


SERVO = Servo(gain=1.15, supply=7.4, current_limit=1.5, motor=GearedMotor(3.4, 0.36))
KNEE = Joint("knee", Link(0.12, 0.1, 0.06, 2e-4), zero=np.pi, spring=Spring(0.6, np.pi - 1.2))
CARRIED = Leg("carried", (Joint("hip", Link(0.15, 0.3, 0.07, 8e-4), drive=SERVO), KNEE))


@pytest.mark.parametrize(("travel", "gravity"), [(None, 9.81), ((1.2, 1.9), 9.81), (None, 0.0)])
def test_a_passive_joint_starts_at_rest(
    travel: tuple[float, float] | None, gravity: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At rotation 0, straight, it started 64 deg from where its spring holds it, and was to be released there."""
    leg = replace(CARRIED.with_joints(knee={"range": travel} | ({} if gravity else {"spring": None})), gravity=gravity)
    time = np.arange(0.0, 1.0, 1.0 / COMMAND_RATE)
    command = np.stack([0.4 * np.sin(6.0 * time) + 0.3, np.full(len(time), -0.8)], axis=1)
    recorded = [command_menu._imagined_command_trial(leg, np.full(2, 1e-3), time, command)]
    monkeypatch.setattr(CommandMenu, "over", lambda self, trial, command: 0.5)  # it needs a bench
    for item in menu(leg, SimpleNamespace(noise=np.full(2, 1e-3)), recorded):  # type: ignore[arg-type]
        hip, knee = item.trial.measured[0]
        np.testing.assert_allclose(leg.to_measured(item.trial.measured[:1])[0], [*item.release.values()], atol=1e-12)
        if not gravity:
            assert knee == pytest.approx(-0.8)  # as recorded: nothing pulls
        elif travel is not None:
            assert item.release["knee"] == pytest.approx(1.9)  # on its stop
        else:
            assert 0.6 * (knee + 1.2) + 0.1 * 9.81 * 0.06 * np.sin(hip + knee) == pytest.approx(0.0, abs=1e-9)


def test_a_planned_command_begins_where_the_servo_holds_the_leg() -> None:
    """A late command and a late reading differed by 0.88 deg in the first 0.1 s: the leg fell from its first command.

    Settled, they are the same, whatever is commanded, and no command is worth recording for them.
    """
    arm = ARM.with_joints(knee={"drive": Servo(8.0, 0.15, torque_limit=1.2)})
    scene, _ = scene_of(arm, driven(arm), Tolerance(), 0)
    sizes = natural_sizes_of(arm, scene.given)
    every = {c.key[0]: c for c in candidates(arm, scene.given, sizes) if c.shape.free == ("delay",)}
    item = next(each for each in menu(arm, scene.bench, scene.given) if each.what == "hard steps from end to end")
    signals = item.trial.recording.signals
    assert signals is not None
    first, found = float(signals.command[0, 0]), []
    nothing = np.zeros(scene.bench.n_tolerance)
    for name in ("command_delay", "latency"):
        delay = every[name].priors[0].coordinate(0.02 / every[name].natural_size(every[name].effect.parameters[0]))
        fit = EvaluatedHypothesis((every[name],), np.append(nothing, delay), ())
        assert every[name].named(fit.unknowns[-1:])["delay"] == pytest.approx(0.02)
        angle, rate = settled_state(scene.bench, fit, arm, item.trial)
        assert 8.0 * (first - angle) == pytest.approx(0.3 * 9.81 * 0.1 * np.sin(angle), abs=1e-4)  # N m
        assert abs(rate) < 1e-4
        covariance = np.eye(len(fit.unknowns))
        told = forecast(arm, scene.bench, fit, item.trial, covariance, {})
        assert told is not None
        found.append(told.mean)
    assert np.abs(found[0] - found[1]).max() < 0.1  # noise floors
