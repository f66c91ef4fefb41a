"""The explicit step beside its tableau as the textbook has it, and lanes with clocks of their own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BPoly

from bench import bench_engine, thesis_leg
from synth.arrays import Array
from synth.swing.chain import FIRST_STEP, Chain, compiled_chain
from synth.swing.effects import effect_named
from synth.swing.explicit_pairs import DAMPED as PAIR
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
        legs.put(effect_named("coulomb_friction"), joint, [torque, 0.0])
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = legs.rest + random.uniform(-0.6, 0.6, (3, LANES))
    return lanes


def by_the_book(chain: Chain, lanes: Array, tolerance: float) -> Array:
    """(n_time, 3, 16) rad by the tableau itself, one step for all lanes; step control of ``dopri5`` with beta 0.07."""
    workspace, rows = np.ascontiguousarray(lanes), chain.layout
    rotation, rate, acceleration = (rows.rows(name) for name in ("rotation", "rate", "acceleration"))

    def slope(y: Array) -> Array:
        workspace[rotation], workspace[rate] = y[:3], y[3:]
        chain.right_hand_side(workspace.reshape(-1))
        return np.concatenate([y[3:], workspace[acceleration]])

    y = np.concatenate([lanes[rotation], lanes[rate]])
    out, t, h, previous, k = [y[:3]], 0.0, FIRST_STEP, 1e-4, [slope(y)]
    while len(out) < len(TIMES):
        h = min(h, TIMES[-1] - t + 1e-15)
        k = k[:1]
        for row in PAIR.stages[1:]:
            new = y + h * sum(a * each for a, each in zip(row, k, strict=True))
            k.append(slope(new))
        missed = h * sum(e * each for e, each in zip(PAIR.error, k, strict=True))
        share = missed / (tolerance + tolerance * np.maximum(abs(y), abs(new)))
        error = float(np.sqrt((share**2).mean(axis=0)).max())
        if error > 1.0:
            h *= max(0.2, 0.9 * error**-0.2)
            continue
        course = BPoly.from_derivatives([0.0, h], [[y[:3], k[0][:3], k[0][3:]], [new[:3], k[6][:3], k[6][3:]]])
        while len(out) < len(TIMES) and TIMES[len(out)] <= t + h + 1e-12:
            out.append(course(TIMES[len(out)] - t))
        y, t, k = new, t + h, [k[6]]
        h *= min(5.0, 0.9 * error**-0.1475 * previous**0.07)
        previous = max(error, 1e-4)
    return np.array(out)


def test_steps_and_results_are_those_of_the_tableau() -> None:
    chain = compiled_chain(3)
    for tolerance in (1e-5, 1e-7):
        lanes = lanes_of(chain, 1)
        # Steps of other sizes differ by a share of the tolerance, a thousand times as much as rounding.
        assert np.abs(chain.run(lanes, TIMES, tolerance) - by_the_book(chain, lanes, tolerance)).max() < 1e-11


def steps_of(chain: Chain, lanes: Array, functions: str) -> int:
    """Steps for the lanes by the integrator with these functions."""
    integrate, *called = getattr(chain, functions)
    taken = []

    def counted(*given: Any) -> Any:
        taken.append(integrate(*given)[0])

    watched = replace(chain)
    watched.__dict__["_plain"] = (counted, *called)
    watched.run(lanes, thesis_leg.TIMES, 3e-5)
    return sum(taken)


@pytest.mark.parametrize(("times_damped", "least", "most"), [(0.15, 0.94, 1.06), (1.0, 0.8, 0.9), (3.0, 0.7, 0.8)])
def test_damped_legs_take_fewer_steps_than_with_dormand_and_prince(
    times_damped: float, least: float, most: float
) -> None:
    chain = compiled_chain(3)
    lanes = bench_engine.our_lanes(chain, *bench_engine.timing_set(LANES))
    lanes[chain.layout.rows("damper_rate")] *= times_damped
    taken = [steps_of(chain, lanes, functions) for functions in ("_plain", "_whole")]
    assert least < taken[0] / taken[1] < most


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
