"""The step of the jumps: conditions of a W-method, damping of what brakes the motor, and the slopes that it uses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from hopper.hoppers import catalogue, motor
from synth.hopper.motors import motor_of
from synth.jump.hopper_leg import Contact, HopperLeg
from synth.jump.jump_models import MODELS, lane, lanes
from synth.jump.jump_runs import TOLERANCE, Jumper, compiled_jump, simulate
from synth.jump.jump_step import G21, G31, G32, G
from synth.jump.outcomes import STATUS, TOO_STIFF

EXPLICIT = np.array([[0, 0, 0], [1 / 2, 0, 0], [0, 3 / 4, 0]])
COUPLED = np.array([[G, 0, 0], [G21, G, 0], [G31, G32, G]])
WEIGHTS = np.array([2 / 9, 1 / 3, 4 / 9])
STEEP = 2.5e4  # 1/s, decay of a standing motor of 75:1
GENTLE = 6e3  # 1/s, of what is left, the winding


def test_conditions_of_a_w_method_hold_for_any_matrix_but_that_of_its_square() -> None:
    # Hairer & Wanner, Solving ODEs II, section IV.7: products of both coefficients of every tree of up to three nodes
    before, coupled = EXPLICIT.sum(axis=1), COUPLED.sum(axis=1)
    found = {
        "f": (WEIGHTS.sum(), 1.0),
        "f' f": (WEIGHTS @ before, 1 / 2),
        "A f": (WEIGHTS @ coupled, 0.0),
        "f'' f f": (WEIGHTS @ before**2, 1 / 3),
        "f' f' f": (WEIGHTS @ EXPLICIT @ before, 1 / 6),
        "f' A f": (WEIGHTS @ EXPLICIT @ coupled, 0.0),
        "A f' f": (WEIGHTS @ COUPLED @ before, 0.0),
        "A A f": (WEIGHTS @ COUPLED @ coupled, G**2 / 2),
    }
    for name, (ours, wanted) in found.items():
        assert ours == pytest.approx(wanted, abs=1e-14), name


def test_a_motion_of_the_matrix_alone_is_damped_for_all_steps_and_vanishes_for_large_ones() -> None:
    whole = EXPLICIT + COUPLED

    def growth(z: complex) -> float:
        return abs(1 + z * WEIGHTS @ np.linalg.solve(np.eye(3) - z * whole, np.ones(3)))

    assert max(growth(-z) for z in np.logspace(-2, 6, 200)) < 1.0
    assert growth(-1e8) < 1e-6
    assert max(growth(1j * z) for z in np.logspace(-2, 4, 200)) < 1.0 + 1e-12


def test_without_the_slopes_by_friction_the_flight_is_a_quarter_as_steep() -> None:
    jumper = compiled_jump("upper")
    flying = _in_flight(jumper, 75)
    layout = jumper.layout
    jacobian, slopes = _jacobian(jumper, flying)
    motors_rate = layout.row("rate")
    left = jacobian.copy()
    left[layout.row("speed") : layout.row("rate") + layout.n - 1, motors_rate] -= slopes
    steepest, rest = (-float(np.linalg.eigvals(matrix).real.min()) for matrix in (jacobian, left))
    assert steepest > STEEP
    assert rest < GENTLE


@pytest.mark.parametrize("ratio", [75, 250])
def test_the_same_jump_in_flight_takes_no_more_steps_than_before_it(ratio: int) -> None:
    jumper = compiled_jump("upper")
    trace = jumper.trace(lane(HopperLeg(), motor(ratio), Contact(), MODELS["full"]))
    time, foot = trace[:, 0], trace[:, 1 + jumper.layout.row("foot")]
    lifted = foot > 1e-3
    pace = [float(np.median(np.diff(time[part]))) for part in (~lifted, lifted)]
    assert pace[1] > 0.5 * pace[0]


@pytest.mark.parametrize("name", ["A", "D"])
def test_no_motor_of_the_catalogue_is_too_stiff(name: str) -> None:
    """Strong slow motors brake light links, and press them on the stop, at up to 1e7/s: they jump like others."""
    motors = [motor_of(row) for row in catalogue().motors if row.complete]
    lengths = np.linspace(0.05, 0.2, 4)
    found = compiled_jump("upper").run(
        np.concatenate([lanes(HopperLeg(), each, Contact(), MODELS[name], lengths) for each in motors], axis=1)
    )
    stiff = (found[STATUS] == TOO_STIFF).reshape(len(motors), -1).any(axis=1)
    assert [each.name for each, yes in zip(motors, stiff, strict=True) if yes] == []


@pytest.mark.parametrize(("part", "least"), [("25D LP 6V 98.78:1", 0.003), ("25D HP 12V 98.78:1", 0.1)])
def test_a_motor_that_brakes_fast_jumps_as_by_short_steps(part: str, least: float) -> None:
    design = (HopperLeg(), motor_of(catalogue().find_motor(part)))
    usual, fine = (simulate([design], Contact(), MODELS["A"], tolerance=each)[0] for each in (TOLERANCE, 1e-6))
    assert usual.clearance > least
    assert usual.clearance == pytest.approx(fine.clearance, abs=2e-4)


def _in_flight(jumper: Jumper, ratio: int) -> np.ndarray:
    """(n_row,) the workspace at the height of a jump."""
    trace = jumper.trace(lane(HopperLeg(), motor(ratio), Contact(), MODELS["full"]))[:, 1:]
    return np.asarray(trace[int(np.argmax(trace[:, jumper.layout.row("foot")]))])


def _jacobian(jumper: Jumper, at: np.ndarray) -> tuple[np.ndarray, Sequence[float]]:
    """(n, n) differences of the right-hand side, and its own slopes by friction and gear."""
    layout, step = jumper.layout, 1e-7
    n = layout.n_state
    workspace = np.repeat(at[:, None], 16, axis=1)
    workspace[layout.row("alive")] = 1.0
    workspace[np.arange(n), 1 + np.arange(n)] += step
    jumper.right_hand_side(workspace)
    change = workspace[layout.block("derivative")]
    return (change[:, 1 : n + 1] - change[:, :1]) / step, workspace[layout.block("own_slope"), 0]
