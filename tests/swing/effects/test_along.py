"""An effect's torque along a given motion is that of the simulation; columns of what is linear add up to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from swing.effects.one_joint import INERTIA, RATE, leg
from swing.effects.test_mirror import GIVEN, TORQUES
from synth.arrays import Array
from synth.swing.chain import simulate
from synth.swing.effects import Effect, effect_named
from synth.swing.effects.torque_along_motion import AlongMotion, torque_along

DAMPER = 0.03
IN_ROTATION = {**GIVEN, "joint_stop": {"upper": 0.2, "lower": -0.3, "stiffness": 20.0, "damping": 0.5}}


def moved(effect: Effect) -> tuple[np.ndarray, ...]:
    """A simulated swing of one joint without gravity, and the torque that the effect must have given it."""
    made = leg({effect.name: IN_ROTATION[effect.name]}, damper=DAMPER)
    time = np.linspace(0, 1, 4001)
    states = simulate(made, [0.5], [0.0], time, tolerance=1e-10, rates=True)
    rotation, rate = states[:, 0], states[:, 1]
    acceleration = np.gradient(rate, time, edge_order=2)
    return time, rotation, rate, INERTIA * acceleration + RATE * rotation + DAMPER * rate


@pytest.mark.parametrize("effect", [e for e in TORQUES if not e.uses_load], ids=lambda effect: effect.name)
def test_it_is_the_torque_that_moved_the_joint(effect: Effect) -> None:
    time, rotation, rate, missing = moved(effect)
    given = [IN_ROTATION[effect.name].get(p.name, effect.defaults[p.name]) for p in effect.parameters]
    along = torque_along(effect, AlongMotion(time, rotation, rate, rotation, RATE, DAMPER, DAMPER * rate, 0.0), given)
    size = np.abs(missing).max()
    assert size > 0.02
    # but for the moments at which it jumps, which differences of rates smear, and over which a bristle turns
    right = np.abs(along - missing) < 0.01 * size
    assert np.mean(right) > 0.96
    assert np.mean(right[:40]) > 0.9


def test_many_columns_agree_with_single_columns() -> None:
    effect = effect_named("spring_hysteresis")
    generator = np.random.default_rng(3)
    time = np.cumsum(generator.uniform(1e-3, 1e-2, 200))
    phase = generator.uniform(0, 6, 37)
    rotation, rate = np.sin(9 * time[:, None] + phase), 9 * np.cos(9 * time[:, None] + phase)
    same = (np.full(37, value) for value in (0.2, 1.0, 1.5, 0.3, 0.0))
    given = np.array([np.linspace(0.1, 1, 37), *same])
    together = torque_along(effect, AlongMotion(time, rotation, rate, rotation - 0.1, RATE, 0.0, 0.0, 0.0), given)
    for k in (0, 15, 16, 36):
        alone = torque_along(
            effect,
            AlongMotion(time, rotation[:, k], rate[:, k], rotation[:, k] - 0.1, RATE, 0.0, 0.0, 0.0),
            given[:, k],
        )
        np.testing.assert_allclose(together[:, k], alone, atol=1e-13)


def test_load_friction_is_proportional_to_the_given_force() -> None:
    effect = effect_named("load_friction")
    time = np.linspace(0, 1, 501)
    rate = np.full(501, 2.0)
    force = 10 + 5 * np.sin(20 * time)
    torque = torque_along(
        effect, AlongMotion(time, 2 * time, rate, 2 * time - 0.3, RATE, 0.0, 0.0, force), [0.01, 0.0, 2e-4]
    )
    np.testing.assert_allclose(torque[10:], -0.01 * force[10:], rtol=1e-9)


def columns_along(effect: Effect, motion: AlongMotion, parameters: Sequence[float]) -> dict[str, Array]:
    """Torque per unit of each strength of an effect that is linear in them, N m per unit of the strength."""
    found = {}
    for strength in effect.strengths:
        unit = np.array(parameters, dtype=float)
        unit[[effect.index(name) for name in effect.strengths]] = 0.0
        unit[effect.index(strength)] = 1.0
        found[strength] = torque_along(effect, motion, unit)
    return found


@pytest.mark.parametrize("effect", [e for e in TORQUES if e.linear], ids=lambda effect: effect.name)
def test_columns_times_strengths_are_the_torque(effect: Effect) -> None:
    time = np.linspace(0, 2, 801)
    rotation, rate = 0.4 * np.sin(7 * time), 2.8 * np.cos(7 * time)
    force = 8 + np.sin(14 * time)
    given = [IN_ROTATION[effect.name].get(p.name, effect.defaults[p.name]) for p in effect.parameters]
    motion = AlongMotion(time, rotation, rate, rotation - 0.1, RATE, DAMPER, DAMPER * rate, force)
    columns = columns_along(effect, motion, given)
    assert set(columns) == set(effect.strengths)
    total = sum(given[effect.index(name)] * column for name, column in columns.items())
    np.testing.assert_allclose(total, torque_along(effect, motion, given), atol=1e-12)


def test_an_effect_that_is_no_torque_is_refused() -> None:
    time = np.linspace(0, 1, 11)
    with pytest.raises(ValueError, match="is not a torque effect"):
        torque_along(effect_named("link_mass"), AlongMotion(time, time, time, time, RATE, 0.0, 0.0, 0.0), [0.1])
