"""Fits to jumps: what was computed holds at its point only, and predictions count all priors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hopper.recorded import DESIGN, PART, Effects, jumped, write
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_candidates import candidates
from synth.diagnosis.plants.jumping_leg.jump_data import pooled_noise
from synth.diagnosis.plants.jumping_leg.jump_diagnosis import JumpingLeg
from synth.diagnosis.plants.jumping_leg.jump_figures import learnt_rises
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump
from synth.diagnosis.plants.jumping_leg.jump_words import other_channels_text
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.jump.hopper_leg import Contact
from synth.jump.jump_models import MODELS
from synth.jump.jump_runs import simulate
from synth.jump.outcomes import LIMITS, TOO_WEAK
from synth.parts.catalogs import Catalogue
from synth.units import significant

NOTHING: Effects = {}


@pytest.fixture(scope="module")
def leg(tmp_path_factory: pytest.TempPathFactory) -> JumpingLeg:
    """One jump as designed."""
    return made(tmp_path_factory.mktemp("jump"))


def made(folder: Path, trial: str = "") -> JumpingLeg:
    """One jump as designed, of a trial with further keys."""
    write(folder / "jumps/0.csv", jumped(0.12, 150, NOTHING, seed=0))
    (folder / "hopper.yaml").write_text(DESIGN)
    head = f'kind: gap\nleg: hopper.yaml\nmotor: "{PART.format(150)}"\nlength: 120 mm\n'
    (folder / "gap.yaml").write_text(f"{head}trials:\n  - {{file: jumps/0.csv{trial}}}\n")
    return JumpingLeg(read_hopper_gap_project(folder / "gap.yaml"), Catalogue.load())


def at_start(bench: JumpBench) -> JumpFit:
    """The design with own unknowns off their priors' centres."""
    return bench.evaluate(JumpFit((), np.zeros(bench.n_tolerance), np.array([[1.5, -1.0]])))


def test_a_fit_elsewhere_has_nothing_that_was_computed_here(leg: JumpingLeg) -> None:
    fit = at_start(leg.bench)
    moved = fit.at(fit.unknowns + 0.1)
    assert (moved.residuals, moved.slopes, moved.cost) == ((), (), np.inf)
    assert moved.own is fit.own


def test_a_fit_is_solved_from_its_point_whatever_it_carries(leg: JumpingLeg) -> None:
    bench = leg.bench
    fit = at_start(bench)
    foreign = JumpFit(fit.hypothesis, fit.unknowns, fit.own, tuple(100.0 * r for r in fit.residuals), fit.slopes, 1e9)
    one, other = (bench.solve(each, rounds=2) for each in (fit, foreign))
    np.testing.assert_array_equal(one.unknowns, other.unknowns)


def test_a_leg_that_does_not_lift_off_rises_by_what_it_stands_up(tmp_path: Path) -> None:
    """An explanation with which a leg lifted by less than 1 mm was said to rise 0 cm; measured were 6.1 cm."""
    bench = made(tmp_path, ", supply: 2.6 V").bench
    ((jump, rise),) = learnt_rises(bench, [JumpFit((), np.zeros(bench.n_tolerance), np.zeros((1, 2)))] * 3)
    (outcome,) = simulate([(jump.leg, jump.motor)], Contact(), MODELS["full"])
    assert outcome.limit == LIMITS[TOO_WEAK]
    assert outcome.rise > 0.02
    assert rise.after == pytest.approx(outcome.rise, rel=1e-3)


def test_readings_beside_the_angle_show_a_cause(leg: JumpingLeg) -> None:
    """The tolerances took the angle to its noise, and the sentence said of a true cause that it reduces no gap."""
    (jump,) = leg.scored
    noise = {name: pooled_noise((jump,), name) for name in jump.measured}

    def predicted(**off: float) -> ScoredJump:
        away = {name.replace("_", " "): times for name, times in off.items()}
        channels = {name: read + away.get(name, 0.0) * noise[name] for name, read in jump.measured.items()}
        return ScoredJump(channels, np.zeros(2))

    said = other_channels_text((jump,), (predicted(upper_link=9.0, ground_force=4.0),), (predicted(),))
    force = [significant(times * noise["ground force"], 2) for times in (4.0, 0.0, 1.0)]
    assert said.endswith(f": ground force from {force[0]} to {force[1]} N (noise {force[2]}).")
    assert not other_channels_text((jump,), (predicted(ground_force=1.0),), (predicted(),))
    assert not other_channels_text((jump,), (predicted(ground_force=4.0),), (predicted(ground_force=5.0),))


def test_a_prospect_counts_the_priors_of_a_trials_own_unknowns(leg: JumpingLeg) -> None:
    """A jump whose clock begins three deviations late, and a cause without strength: no step lowers the cost."""
    (jump,), late = leg.bench.trials, 3.0 * leg.bench.predictor.tolerances.tolerance.start
    bench = replace(leg.bench, trials=(replace(jump, time=jump.time + late),))
    fit = bench.solve(at_start(bench), rounds=60)
    damping = next(each for each in candidates(bench.trials) if each.key[0] == "joint_damping")
    nothing = np.array(damping.starts()[0]) * 1e-9
    (left,) = bench.prospects((damping,), nothing[:, None], fit)
    assert 0.5 * float(np.sum(fit.own**2)) > 2.0
    assert left == pytest.approx(fit.cost, abs=0.5)


def test_intervals_of_jumps_are_as_wide_as_what_is_left(leg: JumpingLeg) -> None:
    """Residuals three times as large: three times as far off, but for what the priors know."""
    fit = at_start(leg.bench)
    size = leg.remainder(fit)
    larger = JumpFit(fit.hypothesis, fit.unknowns, fit.own, tuple(3.0 * r for r in fit.residuals), fit.slopes)
    assert leg.remainder(larger) == pytest.approx(3.0 * size)
    known = leg.normal(fit).parts[0][0]
    free = np.linalg.eigh(known)[1][:, -1]  # the direction that the trial determines best
    near, far = (float(np.sqrt(free @ leg.covariance(each) @ free)) for each in (fit, larger))
    assert far / near == pytest.approx(3.0, rel=0.05)
