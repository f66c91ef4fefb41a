"""Static points of a joint whose free angle shifts from trial to trial: against closed forms of normal errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from scipy.stats import t as student_t

from fit.simulated_legs import bare
from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, Estimate
from synth.files.static_points_file import StaticPoint
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import spread_of_another
from synth.fit.recordings import recordings
from synth.fit.static_points import Balance, groups, independent_residuals, linearised
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

RATE, REST, INERTIA = 1.2, 0.2, 2e-3
SWINGING, OVERDAMPED = (0.01, 0.02), (0.3, 0.3)  # N m s/rad, deg of noise; trials of the second tell b/k alone
TIMES = np.arange(0.0, 2.0, 0.01)
SHIFTS = np.radians([2.0, -1.5, 0.6, -1.1])  # of four trials, about their mean
SPREAD = float(SHIFTS.std(ddof=1))
WIDER = float(student_t.ppf(0.95, 3)) / NORMAL90  # what is estimated from four trials is told by Student's t
SHARE = 0.01  # of a point's torque, its error


def wheel(kind: tuple[float, float], rest: float = REST) -> Leg:
    """A wheel on a spring, without weight."""
    link = Link(0.2, 0.3, 0.0, INERTIA)
    return Leg("wheel", (Joint("axle", link, spring=Spring(RATE, rest), damper=Damper(kind[0])),), gravity=0.0)


@cache
def trials(kind: tuple[float, float], shifted: float = 1.0) -> tuple[Trial, ...]:
    rng, made = np.random.default_rng(3), []
    for k, (start, shift) in enumerate(zip((1.2, -0.8, 0.9, -0.6), SHIFTS, strict=True)):
        moved = simulate(wheel(kind, REST + shifted * shift), [start], [0.0], TIMES)
        made.append(Trial(f"{k}.csv", TIMES, moved + np.radians(kind[1]) * rng.standard_normal(moved.shape)))
    return tuple(made)


def held(turned: float, off: float = 0.0, session: str | None = None, factor: float = 1.0) -> StaticPoint:
    """``turned`` rad from the mean free angle, from which the point's is ``off`` rad; its torque times ``factor``."""
    torque = factor * RATE * (turned - off)
    return StaticPoint(
        f"{turned:.3g}", np.array([REST + turned]), np.array([torque]), (0,),
        torque_error=SHARE * abs(RATE * turned), angle_error=1e-6, session=session,
    )  # fmt: skip


def fitted(kind: tuple[float, float], *points: StaticPoint, shifted: float = 1.0, inertia: float = 0.0) -> FitResult:
    leg = bare(wheel(kind))
    options = LegFitOptions(
        static=points, release="recorded", laws="linear",
        tolerance=Tolerance(length=0.0, mass=0.0, com=0.0, inertia=inertia),
    )  # fmt: skip
    return fit_leg(leg, recordings(leg, trials(kind, shifted)), options)


def half_logarithm(estimate: Estimate) -> float:
    """Standard deviation of a rate's logarithm, of which the 90 % interval is told."""
    assert estimate.low is not None
    assert estimate.high is not None
    return float(0.5 * np.log(estimate.high / estimate.low)) / NORMAL90


def covariance_of_shifts(sessions: Sequence[str | None]) -> Array:
    """(m, m) over the spread's square, as the documentation states it."""
    n = sessions.count(None)
    found = np.zeros((len(sessions), len(sessions)))
    for i, one in enumerate(sessions):
        for j, other in enumerate(sessions):
            if one is None and other is None:
                found[i, j] = (1.0 - 1.0 / n) + (i == j)
            elif one == other:
                found[i, j] = 1.0
    return found


def of_points(turned: Array, covariance: Array, *, spread: float = SPREAD) -> Array:
    """(2, 2) information of balances on log rate and rest, with this covariance of their shifts over the spread's."""
    slopes = np.stack([RATE * turned, np.full(len(turned), -RATE)], axis=1)
    errors = np.diag((SHARE * RATE * turned) ** 2) + (RATE * spread) ** 2 * covariance
    return np.asarray(slopes.T @ np.linalg.solve(errors, slopes))


def balanced(turned: Array, sessions: Sequence[str | None]) -> list[Balance]:
    """Balances that hold exactly at ``RATE`` and a rest of 0."""
    return [
        Balance("", 0, float(at), RATE * float(at), SHARE * RATE * abs(float(at)), 1e-9, session=session)
        for at, session in zip(turned, sessions, strict=True)
    ]


def information(points: Sequence[Balance], spread: float) -> Array:
    total = np.zeros((2, 2))
    for numbers in groups(points):
        slope = linearised([points[k] for k in numbers], float(np.log(RATE)), 0.0, spread)[1]
        total += slope.T @ slope
    return total


@pytest.mark.parametrize(
    "sessions",
    [[None], ["a"], [None, None], [None] * 5, ["a", "a"], ["a", "a", "b"], ["a", None, "a", None, "b", None]],
)
def test_points_tell_what_their_errors_and_shifts_leave(sessions: list[str | None]) -> None:
    turned = np.array([0.5, -0.3, 0.4, 0.7, -0.6, 0.2])[: len(sessions)]
    points = balanced(turned, sessions)
    expected = of_points(turned, covariance_of_shifts(sessions))
    assert information(points, SPREAD) == pytest.approx(expected, rel=1e-6, abs=1e-6 * expected.max())
    # Off the balance: the residuals' squares are those of the whole covariance.
    (first, *others) = (group for group in groups(points))
    group = [points[k] for k in first]
    moved = independent_residuals(group, float(np.log(RATE)), 0.01, SPREAD)
    some = turned[list(first)]
    errors = np.diag((SHARE * RATE * some) ** 2) + (RATE * SPREAD) ** 2 * covariance_of_shifts(
        [sessions[k] for k in first]
    )
    off = np.full(len(some), -RATE * 0.01)
    assert moved @ moved == pytest.approx(off @ np.linalg.solve(errors, off), rel=1e-6)
    assert len(others) == len(set(sessions)) - 1


@pytest.mark.parametrize("count", [1, 2, 3, 7])
@pytest.mark.parametrize("shared", [0.0, 0.3, 1.0])
def test_points_without_a_session_never_tell_too_much(count: int, shared: float) -> None:
    """Whether each has its own shift, all share one, or the shifts have a part in common."""
    turned = np.random.default_rng(count).uniform(-0.8, 0.8, count)
    true = of_points(turned, shared * np.ones((count, count)) + (1.0 - shared) * np.eye(count))
    told = information(balanced(turned, [None] * count), SPREAD)
    assert np.linalg.eigvalsh(true - told).min() > -1e-6 * true.max()


def test_without_a_spread_sessions_change_nothing() -> None:
    turned = np.array([0.5, -0.3, 0.4])
    expected = of_points(turned, np.zeros((3, 3)))
    for sessions in ([None] * 3, ["a"] * 3):
        assert information(balanced(turned, sessions), 0.0) == pytest.approx(expected, rel=1e-6)


def test_the_spread_of_a_point_is_that_of_an_unseen_trial() -> None:
    """Nine in ten shifts of a trial that was not recorded lie within 1.645 of it."""
    generator, sets = np.random.default_rng(5), 20_000
    for count in (2, 3, 5):
        shifts = generator.normal(size=(count + 1, sets))
        spread = np.radians(shifts[:count].std(axis=0, ddof=1))
        wide = spread_of_another(spread, [count] * sets)
        off = np.radians(shifts[count] - shifts[:count].mean(axis=0))
        known = np.hypot(wide, wide / np.sqrt(count))  # of the mean Student's t too
        assert np.mean(np.abs(off) <= NORMAL90 * known) == pytest.approx(0.9, abs=0.01)
    assert spread_of_another(np.radians([1.0, 0.0]), [1, 4]) == pytest.approx([0.0, 0.0])


def test_where_trials_tell_b_over_k_alone_a_point_tells_k_as_far_as_its_shift_allows() -> None:
    """Its own errors of 1 % were stated."""
    turned = 0.6
    found = fitted(OVERDAMPED, held(turned))
    assert found.free_angle == "per_trial"
    axle = found.joints["axle"]
    shift, mean = WIDER * SPREAD, WIDER * SPREAD / 2.0
    of_point = float(np.hypot(SHARE, np.hypot(shift, mean) / turned))
    expected = float(
        1.0 / np.hypot(1.0 / of_point, 1.0 / half_logarithm(fitted(OVERDAMPED).joints["axle"].spring_rate))
    )
    assert half_logarithm(axle.spring_rate) == pytest.approx(expected, rel=0.03)
    assert axle.damper_rate is not None
    assert half_logarithm(axle.damper_rate) == pytest.approx(expected, rel=0.05)
    low, high = axle.free_angle.low, axle.free_angle.high
    assert low is not None
    assert high is not None
    assert 0.5 * (high - low) == pytest.approx(NORMAL90 * mean, rel=0.03)
    assert not any("not separable: spring" in text for text in found.not_separable)


@pytest.mark.parametrize("session", [None, "monday"])
def test_two_points_of_a_session_tell_k_by_the_difference_of_their_torques(session: str | None) -> None:
    """They share a shift of 2.5 deg. Without the session's name that is possible, not certain."""
    turned, off = np.array([0.6, -0.5]), np.radians(2.5)
    found = fitted(OVERDAMPED, *(held(float(at), off, session) for at in turned))
    rate = found.joints["axle"].spring_rate
    assert rate.low is not None
    assert rate.high is not None
    points = of_points(turned, covariance_of_shifts([session, session]), spread=WIDER * SPREAD)
    mean = np.diag([0.0, 4.0 / (WIDER * SPREAD) ** 2])
    expected = float(np.sqrt(np.linalg.inv(points + mean)[0, 0]))
    assert half_logarithm(rate) == pytest.approx(expected, rel=0.05)
    assert rate.low < RATE < rate.high
    if session is not None:
        assert expected < 0.01
        assert rate.value == pytest.approx(RATE, rel=2e-3)


def test_a_point_is_weighed_with_its_shift_beside_the_links_tolerance() -> None:
    """The trials tell k to the inertia's 2 %, the point, 6 % off, to 5.5 %."""
    turned, inertia = 1.0, 0.02
    found = fitted(SWINGING, held(turned, factor=1.06), inertia=inertia)
    of_point = np.hypot(SHARE, np.hypot(WIDER * SPREAD, SPREAD / 2.0) / turned)
    weight = of_point**-2 / (of_point**-2 + inertia**-2)
    rate = found.joints["axle"].spring_rate
    assert np.log(rate.value / RATE) == pytest.approx(weight * np.log(1.06), abs=1.5e-3)
    assert half_logarithm(rate) == pytest.approx(1.0 / np.hypot(1.0 / of_point, 1.0 / inertia), rel=0.03)


def test_a_point_shifted_as_trials_are_contradicts_only_trials_that_are_not() -> None:
    point = held(0.6, np.radians(4.0))
    shifted, same = fitted(SWINGING, point), fitted(SWINGING, point, shifted=0.0)
    assert (shifted.free_angle, same.free_angle) == ("per_trial", "common")
    (among_shifted,), (among_same,) = shifted.static, same.static
    assert not among_shifted.left_out
    assert abs(among_shifted.deviations) < 2.0
    assert not any("static point" in text for text in shifted.warnings)
    assert among_same.left_out
    far = held(0.6, np.radians(25.0))
    assert fitted(SWINGING, far).static[0].left_out


def test_a_session_whose_torques_differ_otherwise_than_the_trials_rate_is_left_out() -> None:
    """Each point is within its shift of the trials' fit; the two together tell a rate 15 % higher."""
    pair = [held(turned, factor=1.15, session="monday") for turned in (0.25, -0.25)]
    for point in pair:
        assert not fitted(SWINGING, point).static[0].left_out
    together = fitted(SWINGING, *pair)
    assert all(item.left_out for item in together.static)
    assert together.joints["axle"].spring_rate.value == pytest.approx(RATE, rel=2e-3)
    separate = fitted(SWINGING, *(held(turned, factor=1.15) for turned in (0.25, -0.25)))
    assert not any(item.left_out for item in separate.static)


def test_the_proposed_point_gives_the_promised_interval_though_it_is_shifted() -> None:
    alone = fitted(OVERDAMPED)
    (proposal,) = alone.proposals
    assert "shifts as from trial to trial" in proposal.sentence
    turned = float(proposal.angles[0]) - REST
    point = StaticPoint(
        "proposed", proposal.angles, np.array([RATE * turned]), (0,),
        torque_error=proposal.torque_error, angle_error=proposal.angle_error,
    )  # fmt: skip
    after = fitted(OVERDAMPED, point).joints["axle"].spring_rate
    assert np.expm1(NORMAL90 * half_logarithm(after)) == pytest.approx(proposal.after, rel=0.15)
    without = fitted(OVERDAMPED, shifted=0.0).proposals
    assert all("shifts as from trial" not in each.sentence for each in without)
