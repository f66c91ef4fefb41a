"""The explicit step beside its tableau as the textbook has it, and lanes with clocks of their own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BPoly

from bench import bench_engine, thesis_leg
from synth.arrays import Array
from synth.swing.chain import FIRST_STEP, Chain, compiled_chain
from synth.swing.effects import effect_named
from synth.swing.explicit_pairs import DAMPED, DORMAND_PRINCE
from synth.swing.lane_layout import LANES
from synth.swing.leg_lanes import LegLanes
from three_links import LEG

TIMES = np.linspace(0.0, 0.5, 126)
FRICTION = (0.15, 0.02, 0.005)  # N m


def lanes_of(chain: Chain, seed: int, friction: bool = False) -> Array:
    """Sixteen different legs of three links at random angles."""
    random = np.random.default_rng(seed)
    legs = LegLanes.of(LEG, LANES)
    legs.spring_rate *= np.exp(random.uniform(-0.3, 0.3, (3, LANES)))
    legs.damper_rate *= np.exp(random.uniform(-0.3, 0.3, (3, LANES)))
    for joint, torque in enumerate(FRICTION if friction else ()):
        legs.put(effect_named("coulomb_friction"), joint, [torque, 0.0, 0.0])
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = legs.rest + random.uniform(-0.6, 0.6, (3, LANES))
    return lanes


def by_the_book(
    chain: Chain, lanes: Array, times: Array, tolerance: float, fast: float = 2.5
) -> tuple[Array, int, int]:
    """(n_time, 3, 16) rad by the tableaus, one step for all lanes, with the step control of ``dopri5``.

    The second pair, with beta 0.07, where a step times the fastest decay exceeds ``fast``. Also the number of steps,
    and of those with that pair.
    """
    workspace, rows = lanes.copy(), chain.layout
    rotation, rate, acceleration = (rows.rows(name) for name in ("rotation", "rate", "acceleration"))

    def slope(y: Array) -> Array:
        workspace[rotation], workspace[rate] = y[:3], y[3:]
        chain.right_hand_side(workspace.reshape(-1))
        return np.concatenate([y[3:], workspace[acceleration]])

    y = np.concatenate([lanes[rotation], lanes[rate]])
    out, t, h, previous, k = [y[:3]], 0.0, FIRST_STEP, 1e-4, [slope(y)]
    change = np.tile(np.array([[1.0], [-1.0], [1.0]]), LANES)
    for _ in range(5):  # power iteration
        change = (slope(y + 1e-3 * np.concatenate([0.0 * change, change]))[3:] - k[0][3:]) / 1e-3
        decay = float(np.abs(change).max())
        change /= np.abs(change).max(axis=0)
    steps, damped = 0, 0
    while len(out) < len(times):
        h = min(h, times[-1] - t + 1e-15)
        pair, beta = (DAMPED, 0.07) if h * decay > fast else (DORMAND_PRINCE, 0.04)
        k, steps, damped = k[:1], steps + 1, damped + (pair is DAMPED)
        for row in pair.stages[1:]:
            new = y + h * sum(a * each for a, each in zip(row, k, strict=True))
            k.append(slope(new))
        missed = h * sum(e * each for e, each in zip(pair.error, k, strict=True))
        share = missed / (tolerance + tolerance * np.maximum(abs(y), abs(new)))
        error = float(np.sqrt((share**2).mean(axis=0)).max())
        if error > 1.0:
            h *= max(0.2, 0.9 * error**-0.2)
            continue
        course = BPoly.from_derivatives([0.0, h], [[y[:3], k[0][:3], k[0][3:]], [new[:3], k[6][:3], k[6][3:]]])
        while len(out) < len(times) and times[len(out)] <= t + h + 1e-12:
            out.append(course(times[len(out)] - t))
        y, t, k = new, t + h, [k[6]]
        h *= min(5.0, 0.9 * error ** -(0.2 - 0.75 * beta) * previous**beta)
        previous = max(error, 1e-4)
    return np.array(out), steps, damped


@pytest.mark.parametrize(("times_damped", "tolerance"), [(0.1, 1e-5), (0.1, 1e-7), (3.0, 1e-5), (3.0, 1e-7)])
def test_steps_and_results_are_those_of_the_tableaus(times_damped: float, tolerance: float) -> None:
    chain = compiled_chain(3)
    lanes = lanes_of(chain, 1)
    lanes[chain.layout.rows("damper_rate")] *= times_damped
    expected, _, damped = by_the_book(chain, lanes, TIMES, tolerance)
    # Steps of other sizes differ by a share of the tolerance, a thousand times as much as rounding.
    assert np.abs(chain.run(lanes, TIMES, tolerance) - expected).max() < 1e-11
    assert (damped > 10) == (times_damped > 1.0)


@pytest.mark.parametrize(("times_damped", "least", "most"), [(0.15, 0.99, 1.01), (1.0, 0.8, 0.87), (3.0, 0.72, 0.8)])
def test_damped_legs_take_fewer_steps_than_with_dormand_and_prince(
    times_damped: float, least: float, most: float
) -> None:
    chain, times = compiled_chain(3), thesis_leg.TIMES
    lanes = bench_engine.our_lanes(chain, *bench_engine.timing_set(LANES))
    lanes[chain.layout.rows("damper_rate")] *= times_damped
    with_both, alone = (by_the_book(chain, lanes, times, 3e-5, fast) for fast in (2.5, np.inf))
    assert least < with_both[1] / alone[1] < most
    assert np.abs(with_both[0] - alone[0]).max() < 3e-5


def test_clocks_of_their_own_give_what_common_steps_give() -> None:
    # A known torque of zero is integrated with common steps, cut at the turns of all lanes.
    chain, nothing = compiled_chain(3), (np.array([0.0, 1.0]), np.zeros((2, 3)))
    lanes = lanes_of(chain, 2, friction=True)
    own, common = chain.run(lanes, TIMES, 1e-9), chain.run(lanes, TIMES, 1e-9, known_torque=nothing)
    assert np.abs(own - lanes[chain.layout.rows("rotation")]).max() > 0.3
    # Where one bends and the other slides at a turn, a held joint may differ by the deflection of its bristle.
    assert np.median(np.abs(own - common).max(axis=(0, 1))) < 1e-7
    assert np.abs(own - common).max() < 2e-4


def test_a_leg_moves_alone_as_among_others() -> None:
    chain = compiled_chain(3)
    lanes = lanes_of(chain, 3, friction=True)
    together = chain.run(lanes, TIMES, 1e-8, rates=True)
    alone = chain.run(lanes[:, 5:6], TIMES, 1e-8, rates=True)
    np.testing.assert_allclose(together[:, :, 5], alone[:, :, 0], atol=1e-9)


def test_copies_of_a_leg_share_their_steps() -> None:
    # Derivatives by copies that are a part in 1e5 apart, beside those of wide and fine differences
    chain = compiled_chain(3)
    lanes = np.repeat(lanes_of(chain, 4, friction=True)[:, :1], 4, axis=1)
    moved = chain.layout.row("spring_rate")

    def slopes(step: float, tolerance: float) -> Array:
        copies = lanes.copy()
        copies[[moved, moved + 1, moved + 2], [1, 2, 3]] *= 1.0 + step
        found = chain.run(copies, TIMES, tolerance)
        return (found[:, :, 1:] - found[:, :, :1]) / step

    expected = 0.5 * (slopes(1e-4, 1e-10) + slopes(-1e-4, 1e-10))
    assert np.abs(slopes(1e-5, 1e-6) - expected).max() < 0.02 * np.abs(expected).max()
