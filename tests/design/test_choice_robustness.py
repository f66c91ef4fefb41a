"""How the uncertainty of the fit affects the choice of parts: drawn legs, and sets compared on them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fit.simulated_legs import Rig, bare, recorded, releases, robot
from fit.test_static_points import OVERDAMPED
from synth.design.choice_robustness import ChoiceRobustness, choice_robustness
from synth.design.part_sets import SetsMade
from synth.design.response import WantedResponse
from synth.design.stages import releases as released
from synth.fit.draws import DRAWS
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.swing.leg_model import Leg


def fit_of(leg: Leg, noise: float, **options: object) -> tuple[FitResult, WantedResponse]:
    recordings = recorded(leg, releases(leg, 3, Rig(noise=noise, rate=250.0), 3))
    fit = fit_leg(bare(leg), recordings, LegFitOptions(free_angle="common", **options))  # type: ignore[arg-type]
    return fit, WantedResponse.of(fit.leg, released(recordings, fit))


def rates(legs: tuple[Leg, ...]) -> np.ndarray:
    """(2, n_leg, n) logarithms of spring and damper rates."""
    found = [
        [[joint.spring.rate, joint.damper.rate] for joint in leg.joints if joint.spring and joint.damper]
        for leg in legs
    ]
    return np.log(np.array(found, dtype=float)).transpose(2, 0, 1)


def stiffer(leg: Leg, joint: str, factor: float) -> Leg:
    spring = leg.joints[leg.joint_names.index(joint)].spring
    assert spring is not None
    return leg.with_joints(**{joint: {"spring": replace(spring, rate=spring.rate * factor)}})


def test_draws_scatter_as_the_intervals_and_follow_the_ridge() -> None:
    fit, _ = fit_of(OVERDAMPED, 0.5)
    assert len(fit.drawn) == DRAWS
    spring, damper = rates(fit.drawn)
    estimate = fit.joints["hip"].spring_rate
    assert estimate.low is not None
    assert estimate.high is not None
    sd = np.log(estimate.high / estimate.low) / 2 / 1.645
    assert spring[:, 0].std() == pytest.approx(sd, rel=0.3)
    assert (damper - spring)[:, 0].std() < 0.1 * spring[:, 0].std()  # b/k is known ten times as well as k


def test_bootstrap_refits_are_used_as_draws() -> None:
    fit, _ = fit_of(robot(), 0.2, intervals="bootstrap")
    assert len(fit.drawn) == DRAWS
    normal, _ = fit_of(robot(), 0.2)
    both = [rates(item.drawn)[0].std(axis=0) for item in (fit, normal)]
    assert both[0] == pytest.approx(both[1], rel=0.5)


def test_the_exact_set_is_best_in_every_draw() -> None:
    fit, wanted = fit_of(robot(), 0.2)
    found = choice_robustness(wanted, fit, [fit.leg, stiffer(fit.leg, "knee", 1.3)], [0.0, 0.0])
    assert found is not None
    assert found.best.tolist() == [1.0, 0.0]
    assert found.errors[0] == pytest.approx(found.wanted, rel=1e-4)  # the first set is the fitted leg itself
    assert np.all(found.errors[1] > found.errors[0])
    assert found.warning is None
    written = found.as_json()
    assert written["chosen_is_best"] == {"value": 1.0, "unit": "1"}
    low, high = written["chosen"]["interval90"]
    assert low <= written["chosen"]["value"] <= high


def test_indistinguishable_sets_give_a_warning() -> None:
    fit, wanted = fit_of(robot(), 0.5)
    sets = [stiffer(fit.leg, "knee", factor) for factor in (0.97, 1.03, 1.0)]
    found = choice_robustness(wanted, fit, sets, [0.0] * 3)
    assert found is not None
    assert found.best[0] < 0.5
    assert found.warning is not None
    assert "depends on the uncertainty of the fit" in found.warning


def test_where_tolerances_decide_the_choice_the_uncertainty_of_the_fit_is_not_blamed() -> None:
    fit, wanted = fit_of(robot(), 0.2)
    sets = [stiffer(fit.leg, "knee", 1.3), fit.leg]
    far = choice_robustness(wanted, fit, sets, [0.0, 0.0])
    assert far is not None
    assert far.best.tolist() == [0.0, 1.0]
    # The second set is nearer in every draw, but its parts scatter by more than the first is off.
    off = float(far.errors[0].max())
    found = choice_robustness(wanted, fit, sets, [(0.1 * off) ** 2, (1.5 * off) ** 2])
    assert found is not None
    assert found.best.tolist() == [1.0, 0.0]
    assert found.warning is None
    assert found.as_json()["chosen"] == far.as_json()["chosen"]  # still with nominal parts


def test_a_choice_by_tolerances_is_the_best_of_its_own_comparison() -> None:
    nominal, ready = (0.018, 0.011), (0.028, 0.034)  # rad; the chosen set is the first
    sets = [
        SimpleNamespace(expected_as_others=expected, ready=SimpleNamespace(nominal=own))
        for own, expected in zip(nominal, ready, strict=True)
    ]
    made: Any = SimpleNamespace(sets=sets)
    assert SetsMade.added_by_tolerances.fget is not None
    added = np.array(SetsMade.added_by_tolerances.fget(made))
    assert np.sqrt(np.square(nominal) + added) == pytest.approx(ready)


def test_without_draws_there_is_no_warning() -> None:
    fit, wanted = fit_of(robot(), 0.2)
    assert choice_robustness(wanted, replace(fit, drawn=()), [fit.leg], [0.0]) is None
    assert ChoiceRobustness(np.array([[1.0, 2.0]]), np.array([1.0, 2.0]), np.zeros(1)).warning is None


def test_a_set_that_diverges_is_off_by_pi_whatever_the_number_of_joints() -> None:
    motion = np.zeros((5, 3, 1))
    sets: Any = ("diverging", "same")
    simulated = {sets: [np.concatenate([np.full_like(motion, np.nan), motion], axis=2)], "draws": [motion]}
    release = SimpleNamespace(conditions=SimpleNamespace(locked=()))
    wanted: Any = SimpleNamespace(releases=[release], motions=[motion[:, :, 0]], simulate=simulated.__getitem__)
    fit: Any = SimpleNamespace(drawn="draws", leg=SimpleNamespace(joints=(1, 2, 3)))
    made = choice_robustness(wanted, fit, sets, [0.0, 0.0])
    assert made is not None
    assert made.errors[:, 0] == pytest.approx([np.pi, 0.0])
