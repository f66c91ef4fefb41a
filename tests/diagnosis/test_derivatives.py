"""Predictions, linearisations and columns computed in lanes, against single simulations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, NOISE, TWO, off, read, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block
from synth.diagnosis.odds import shape_cost
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.diagnosed_leg import diagnosed_leg
from synth.diagnosis.workbench import Workbench
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo
from synth.files.tolerance import Tolerance
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.effects import registered
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.tolerances import Tolerances

TOLERANCES = Tolerances.of(TWO, Tolerance())
CONDITIONS = (Conditions(), Conditions((0,)), Conditions((), 0.05), Conditions((), 0.0, 0.3))


def made_trials() -> tuple[AngleTrial, ...]:
    """A trial under each of ``CONDITIONS``; the leg as designed but for its tolerances."""
    leg, found = off(TWO, 3, 0.5), []
    for number, conditions in enumerate(CONDITIONS):
        found += recorded(leg, AWAY[number : number + 1], conditions=conditions, held_out=0, seed=number, first=number)
    return tuple(angle_trial(recording, held_out=False) for recording in recordings(TWO, found, ()))


TRIALS = made_trials()
BENCH = Workbench(Predictor(TWO, TOLERANCES), TRIALS, np.full(2, NOISE), 50.0)
CANDIDATES = [c for c in candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS)) if c.shape is c.effect.shapes[0]]


def started(hypothesis: tuple[Candidate, ...] = ()) -> EvaluatedHypothesis:
    """A point off the nominal one, each cause at its first start, each trial from where it was let go."""
    tolerances = 0.5 * np.random.default_rng(7).standard_normal(TOLERANCES.size)
    starts = [candidate.starts()[0] for candidate in hypothesis]
    states = []
    for trial in TRIALS:
        state = np.concatenate([trial.recording.smoothed.angle[0], np.zeros(2)])
        state[[2 + j for j in trial.free]] = 0.3
        states.append(state)
    return EvaluatedHypothesis(hypothesis, np.concatenate([tolerances, *starts]), tuple(states))


def simulated_alone(fit: EvaluatedHypothesis, number: int, state: Array | None = None) -> Array:
    """(m, n) rad: the leg that the fit stands for as a leg file would hold it, simulated on its own and read."""
    trial = TRIALS[number]
    leg = diagnosed_leg(TWO, TOLERANCES, fit, ())
    begin = fit.states[number] if state is None else state
    if any(candidate.effect.way == "structure" for candidate in fit.hypothesis):
        return simulate_with_initial_deflection(leg, fit.hypothesis[0], begin, trial)
    motion = simulate(leg, begin[:2], begin[2:], trial.time, trial.recording.conditions, tolerance=1e-9, rates=True)
    return read(leg, trial.time, motion[:, :2], motion[:, 2:])


def simulate_with_initial_deflection(leg: Leg, candidate: Candidate, state: Array, trial: AngleTrial) -> Array:
    """As ``simulate``, but for the added link, which is deflected by what held the leg before its release."""
    legs = LegLanes.whole(leg)
    chain, own = compiled_chain(legs.n), list(legs.own)
    (added,) = set(range(legs.n)) - set(own)
    rotation, rate = np.zeros((legs.n, 1)), np.zeros((legs.n, 1))
    rotation[own, 0], rate[own, 0] = state[:2], state[2:]
    rotation[added] = candidate.effect.function("start")(legs, legs.own[candidate.joint], rotation)
    lanes = chain.lanes(legs, trial.recording.conditions)
    lanes[chain.layout.rows("rotation")], lanes[chain.layout.rows("rate")] = rotation, rate
    return chain.run(lanes, trial.time, 1e-9)[:, own, 0]


def slope(fit: EvaluatedHypothesis, number: int, index: int, step: float) -> Array:
    """(m, n) rad, central difference by one unknown."""
    ends = []
    for side in (1.0, -1.0):
        moved = fit.unknowns.copy()
        moved[index] += side * step
        ends.append(simulated_alone(replace(fit, unknowns=moved), number))
    return np.asarray((ends[0] - ends[1]) / (2.0 * step))


def unwhitened(number: int, column: Array) -> Array:
    """A column of a trial's samples as (m, n) rad, zero where none counts."""
    trial = TRIALS[number]
    found = np.zeros(trial.measured.shape)
    found[trial.counts] = column[: int(trial.counts.sum())]
    return found * BENCH.sigma(trial)


def close(found: Array, expected: Array, counts: Array, share: float) -> None:
    """Equal within a share of the greatest."""
    most = np.abs(expected[counts]).max()
    assert np.abs(found - expected)[counts].max() <= share * most + 1e-7


@pytest.mark.parametrize("number", range(len(CONDITIONS)))
def test_tolerance_columns_equal_finite_differences(number: int) -> None:
    fit = started()
    part = BENCH.frame(fit).trials[number]
    for index in range(TOLERANCES.size):
        expected = slope(fit, number, index, 0.02)
        close(unwhitened(number, part.common[:, index]), expected, TRIALS[number].counts, 0.01)


@pytest.mark.parametrize("number", range(len(CONDITIONS)))
def test_state_columns_equal_finite_differences(number: int) -> None:
    fit, trial = started(), TRIALS[number]
    part = BENCH.frame(fit).trials[number]
    columns = part.q @ part.r
    rows = [*trial.free, *[2 + j for j in trial.free]]
    for column, row in enumerate(rows):
        ends = []
        for side in (1.0, -1.0):
            moved = fit.states[number].copy()
            moved[row] += side * 1e-4
            ends.append(simulated_alone(fit, number, moved))
        close(unwhitened(number, columns[:, column]), (ends[0] - ends[1]) / 2e-4, trial.counts, 0.02)


@pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda c: "-".join(c.key))
def test_the_written_leg_moves_as_predicted(candidate: Candidate) -> None:
    """For every effect at every place: lanes with unknowns in, and the diagnosed leg on its own."""
    fit = started((candidate,))
    block = Block(fit.hypothesis, fit.unknowns[:, None], fit.states[0][None, :, None])
    found = BENCH.predictor.predict([TRIALS[0]], [block])[0][:, :, 0]
    assert np.abs(found - simulated_alone(fit, 0)).max() < 0.1 * NOISE


@pytest.mark.parametrize("name", ["quadratic_damping", "hardening_spring", "link_mass", "encoder_scale", "latency"])
def test_effect_columns_equal_finite_differences(name: str) -> None:
    (candidate,) = (c for c in CANDIDATES if c.effect.name == name and c.joint == 1)
    (fit,) = BENCH.evaluate([started((candidate,))])
    for number in (0, 2):
        for k in range(candidate.size):
            expected = slope(fit, number, TOLERANCES.size + k, 1e-3)
            close(unwhitened(number, fit.columns[number][:, k]), expected, TRIALS[number].counts, 0.02)


def test_predictions_do_not_depend_on_the_grouping_into_blocks() -> None:
    """Blocks share lanes with others of their structure; the grouping must not matter."""
    some = [c for c in CANDIDATES if c.effect.name in ("coulomb_friction", "quadratic_damping", "base_compliance")]
    fits = [started((candidate,)) for candidate in some]
    together = BENCH.evaluate(fits)
    for fit, found in zip(fits, together, strict=True):
        (alone,) = BENCH.evaluate([fit])
        for one, other in zip(alone.residuals, found.residuals, strict=True):
            np.testing.assert_allclose(one, other, atol=2e-2)  # of the noise


def fitted_nominal(bench: Workbench) -> EvaluatedHypothesis:
    """The nominal leg within its tolerances, with derivatives of its own."""
    states = tuple(np.concatenate([t.recording.smoothed.angle[0], t.recording.smoothed.rate[0]]) for t in bench.trials)
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), states)
    for _ in range(3):
        (fit,) = bench.solve([replace(fit, damping=1e-3, done=False)], bench.frame(fit), 3, 1e-3)
    return replace(fit, frame=bench.frame(fit))


def test_leaving_a_trial_out_in_closed_form_equals_a_refit() -> None:
    """The closed form against a fit of the other trials."""
    fit = fitted_nominal(BENCH)
    assert fit.frame is not None
    step = BENCH.normal(fit).without(2)
    others = [number for number in range(len(TRIALS)) if number != 2]
    less = replace(BENCH, trials=tuple(TRIALS[number] for number in others))
    again = fitted_nominal(less)
    spread = np.abs(again.unknowns - fit.unknowns).max()
    assert spread > 0.02  # the trial says something
    assert np.abs(fit.unknowns + step - again.unknowns).max() < 0.05 * spread


def test_every_effect_is_a_candidate_or_is_read_from_the_recordings() -> None:
    driven = {
        "torque",
        "servo",
        "motor",
        "held commands",
        "stated supply",
        "shared supply",
        "time to warm",
        "driven rotor",
    }  # no torque is known in these trials, and no drive is there
    of_drives = {effect.name for effect in registered() if driven & set(effect.needs)}
    expected = {effect.name for effect in registered()} - {"encoder_quantisation"} - of_drives
    assert {c.effect.name for c in CANDIDATES} == expected


def test_an_effect_that_needs_a_missing_part_is_no_candidate() -> None:
    bare = TWO.with_joints(knee={"spring": Spring(0.0, 0.0), "damper": Damper(0.0)})
    known = (TRIALS[0].recording.time[[0, -1]], np.array([[0.0, 0.1], [0.0, 0.2]]))
    trial = replace(TRIALS[0], recording=replace(TRIALS[0].recording, known_torque=known))
    found = candidates(bare, [trial], natural_sizes_of(bare, [trial]))
    there = {joint: {c.effect.name for c in found if c.key[1] == joint} for joint in bare.joint_names}
    springs = {"hardening_spring", "one_sided_spring", "spring_hysteresis", "spring_preload"}
    assert springs | {"backlash", "shear_thinning_damping"} <= there["hip"]
    assert not (springs | {"backlash", "shear_thinning_damping"}) & there["knee"]
    assert {"spring_rate", "viscous_damping", "armature"} <= there["hip"] & there["knee"]
    assert [c.shape.free for c in found if c.key == ("spring_rate", "hip")] == [("rate",)]
    assert [c.shape.free for c in found if c.key == ("spring_rate", "knee")] == [("rate", "free_angle")]
    assert {name for name in there["knee"] if name.startswith("torque_")} == {
        "torque_offset",
        "torque_gain",
        "torque_delay",
    }
    assert not [name for name in there["hip"] if name.startswith("torque_")]


def test_with_effects_sets_joint_and_base_effects() -> None:
    leg = with_effects(TWO, {"knee": {"coulomb_friction": {"torque": 0.02}}, "base": {"base_tilt": {"tilt": 0.1}}})
    assert leg.joints[1].effects == {"coulomb_friction": {"torque": 0.02}}
    assert leg.effects == {"base_tilt": {"tilt": 0.1}}


def test_a_diverging_derivative_costs_odds_and_makes_no_nan() -> None:
    """One diverging neighbour of a hopeless fit made every cause's probability NaN."""
    cause = next(c for c in CANDIDATES if c.key == ("joint_stop", "knee"))
    fit = started((cause,))
    framed = BENCH.frame(fit)
    spoilt = replace(framed.trials[0], q=np.full_like(framed.trials[0].q, np.nan))
    columns = tuple(np.ones((len(part.common), cause.size)) for part in framed.trials)
    residuals = tuple(np.ones(len(part.common)) for part in framed.trials)
    fit = replace(fit, unknowns=fit.unknowns + 1.0, residuals=residuals, columns=columns)
    sound = replace(fit, frame=framed).shapes
    diverged = replace(fit, frame=replace(framed, trials=(spoilt, *framed.trials[1:]))).shapes
    assert len(sound) > 1
    assert np.isfinite(sound).all()
    assert np.all(diverged[:, 1] == np.inf)
    assert shape_cost(diverged) == pytest.approx(0.5 * np.sum(sound[:, 0] ** 2))


def test_a_lighter_rotor_is_written_as_a_rotor() -> None:
    """A leg file refuses an armature below zero."""
    motor = GearedMotor(2.0, 0.02, gear_ratio=50.0, rotor_inertia=2e-6, inductance=2e-3)
    driven = TWO.with_joints(hip={"drive": Servo(5.0, supply=12.0, motor=motor)})
    shapes = [
        c
        for c in candidates(driven, TRIALS, natural_sizes_of(driven, TRIALS))
        if c.effect.name == "armature" and c.joint == 0
    ]
    fit = EvaluatedHypothesis((shapes[0],), np.r_[np.zeros(TOLERANCES.size), -0.1], ())
    changed = shapes[0].named(fit.unknowns[-1:])["inertia"]
    hip = diagnosed_leg(driven, TOLERANCES, fit, ()).joints[0]
    assert changed < 0.0
    assert hip.armature == 0.0
    assert hip.with_whole_rotor == pytest.approx(max(0.0, 5e-3 + changed))
