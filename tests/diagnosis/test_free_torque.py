"""A torque that no listed effect has, simulated by MuJoCo: its joint, its shape, and its gain on held-out trials."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from peers.mujoco_leg import simulate
from synth.arrays import Array
from synth.diagnosis.angle_search import search
from synth.diagnosis.hypotheses import TrialErrors
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.free_torque import FreeTorque, _free_torque_of, free_torques
from synth.diagnosis.plants.swinging_chain.torque_hats import Hats
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial

TIME = np.arange(401) * 0.005
AWAY = np.array([[0.5, 0.6], [-0.4, 0.7], [0.35, -0.6], [0.6, -0.8], [-0.5, -0.5], [0.2, 0.9]])
NOISE = np.radians(0.02)
Law = Callable[[float, float], float]  # torque on q at the knee from deflection and rate


def found(law: Law | None) -> tuple[FreeTorque, ...]:
    """The free torques of the design that lacks the law."""
    rest = TWO.rest
    generator = np.random.default_rng(3)

    def extra(rotation: Array, rate: Array) -> Array:
        return np.array([0.0, law(float(rotation[1] - rest[1]), float(rate[1])) if law else 0.0])

    trials = []
    for number, away in enumerate(AWAY):
        rotation = simulate(TWO, rest + away, np.zeros(2), TIME, step=5e-4, extra_torque=extra)
        angles = TWO.to_measured(rotation) + NOISE * generator.standard_normal(rotation.shape)
        trials.append(Trial(f"{number}.csv", TIME, angles))
    scene, _ = scene_of(TWO, trials, Tolerance(), 0)
    base = search(scene.bench, [], CALIBRATED).none.fit
    return free_torques(
        TWO, scene.tolerances.leg(TWO, base.unknowns), scene.bench, base, natural_sizes_of(TWO, scene.given)
    )


def alike(item: FreeTorque, true: Array, where: Array) -> float:
    """Correlation of curve and law but for their linear parts, which spring and damper tolerances trade."""
    columns = np.column_stack([item.place[where], np.ones(int(where.sum()))])
    left = [y[where] - columns @ np.linalg.lstsq(columns, y[where], rcond=None)[0] for y in (item.torque, true)]
    return float(np.corrcoef(*left)[0, 1])


def test_knee_cogging_is_located_with_its_shape() -> None:
    """0.02 N m with a period of 1.2 rad: six hats a period see it, no effect of the library has it."""
    first, second = found(lambda deflection, _: -0.02 * np.sin(2 * np.pi * deflection / 1.2))
    assert (first.joint, first.over) == ("knee", "deflection")
    assert first.taken > 0.6
    assert first.taken > second.taken + 0.2
    # In the measured sense both torque and deflection turn round (sign -1): the law is odd, so it stays.
    true = -0.02 * np.sin(2 * np.pi * first.place / 1.2)
    assert alike(first, true, np.abs(first.place) < 0.7) > 0.8


def test_a_speed_dependent_torque_is_found_over_speed() -> None:
    """Drag that sets in above 2 rad/s; the measured angle's sense is the other one, the law is odd."""

    def drag(_: float, rate: float) -> float:
        return -0.01 * np.sign(rate) * max(abs(rate) - 2.0, 0.0)

    first = found(drag)[0]
    assert (first.joint, first.over) == ("knee", "speed")
    assert first.taken > 0.4
    assert alike(first, np.array([drag(0.0, place) for place in first.place]), np.abs(first.place) < 12.0) > 0.9


def test_a_complete_model_has_no_free_torque() -> None:
    assert found(None) == ()


def test_as_json_holds_every_number_with_its_unit() -> None:
    first = found(lambda deflection, _: -0.05 * np.sin(8 * deflection))[0].as_json()
    assert set(first) == {"joint", "over", "taken", "curve"}
    lengths = {len(first["curve"][name]["value"]) for name in ("place", "torque", "low", "high")}
    assert lengths == {len(first["curve"]["direction"])}


@pytest.mark.parametrize("folds", [2, 3, 5])
def test_the_interval_of_the_curve_holds_where_folds_are_few(folds: int) -> None:
    """Heights that are means of independent ones, each without one; the truth is 0. It held 66, 76 and 83 %."""
    generator, number = np.random.default_rng(0), 4000
    hats = Hats(1, "speed", np.linspace(-5.0, 5.0, number), 0.0, 0.3, 5.0)
    one = generator.standard_normal((folds, number))
    each = (one.sum(axis=0) - one) / (folds - 1)
    errors = TrialErrors(np.ones((folds, 1)), np.ones((folds, 1)), np.ones(folds))
    problem: Any = SimpleNamespace(hats=hats)
    made = _free_torque_of(TWO, problem, errors, each, errors)
    assert np.mean((made.low <= 0.0) & (made.high >= 0.0)) == pytest.approx(0.9, abs=0.02)
