"""The score against cases counted by hand and closed forms."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np
import pytest

from blind.chance import bootstrap, calibrated_by_chance, calibration_error, reliability, wilson
from blind.score import (
    Level,
    confusion,
    gain,
    outcome_odds,
    reported,
    right,
    scores,
    shares_of_best,
    shrink_of,
)
from blind.views import FAILED, View

FRICTION, PRELOAD, TILT = ("coulomb_friction", "knee"), ("spring_preload", "hip"), ("base_tilt", "base")


def answer(kind: str, *causes: tuple[str, str], strength: float = 6.0, alike: tuple[Any, ...] = ()) -> dict[str, Any]:
    effects = [{"effect": e, "joint": j, "strength": strength, "reached": strength, "form": "x"} for e, j in causes]
    return {
        "kind": kind, "effects": effects, "cannot_be_told_apart": [list(key) for key in alike],
        "noise_floor_deg": 0.3, "before_deg": 0.5, "best_possible_deg": 0.3, "best_fitted_deg": 0.3, "seed": [1, 1],
    }  # fmt: skip


def view(verdict: str, *ranked: tuple[tuple[str, str], float], tied: tuple[Any, ...] = (), after: float = 0.5) -> View:
    named = () if verdict in ("none", "unknown") else (ranked[0][0],)
    return View(verdict, ranked, named, tied, none=0.0, unknown=0.0, after=after)


def test_the_interval_of_a_share_is_wilsons() -> None:
    # ends solve (p - x)^2 = z^2 x (1 - x) / n
    for right_, count in ((0, 10), (3, 10), (10, 10)):
        for end in wilson(right_, count):
            share = right_ / count
            assert (share - end) ** 2 == pytest.approx(1.6448536269514722**2 * end * (1 - end) / count, abs=1e-9)
    assert wilson(0, 0) == (0.0, 1.0)


def test_the_bootstrap_of_a_mean_is_as_wide_as_its_standard_error() -> None:
    rows = np.random.default_rng(1).standard_normal(400)
    low, high = bootstrap(rows, lambda x: float(x.mean()))
    assert high - low == pytest.approx(2 * 1.645 * rows.std() / 20, rel=0.1)


def test_calibration_error_is_the_mean_miss_of_the_bins() -> None:
    rows = np.array([[0.95, 1.0], [0.95, 0.0], [0.25, 0.0], [1.0, 1.0]])
    assert [count for _, count, *_ in reliability(rows)] == [1, 3]
    assert calibration_error(rows) == pytest.approx(0.75 * (2.9 / 3 - 2 / 3) + 0.25 * 0.25)
    assert calibrated_by_chance([0.5] * 4000) < 0.02
    assert calibrated_by_chance([0.5]) == pytest.approx(0.5)


def test_the_shrink_is_of_errors_above_the_floor() -> None:
    assert shrink_of(0.3, 0.5, 0.3) == 1.0
    assert shrink_of(0.5, 0.5, 0.3) == 0.0
    assert shrink_of(math.hypot(0.3, 0.1), 0.5, 0.3) == pytest.approx(0.75)
    answers = {"a": answer("single", FRICTION), "b": answer("none"), "c": answer("single", FRICTION, strength=1.5)}
    views = {name: view("effect", (FRICTION, 1.0), after=math.hypot(0.3, 0.1)) for name in answers}
    assert shares_of_best(answers, views, "best_possible_deg") == pytest.approx([0.75])
    assert shares_of_best(answers, {"a": FAILED, "b": FAILED, "c": FAILED}, "best_possible_deg") == pytest.approx([0.0])


def test_scores_of_few_cases_are_those_counted_by_hand() -> None:
    answers = {
        "right": answer("single", FRICTION),
        "second": answer("single", FRICTION),
        "joint": answer("single", FRICTION),
        "faint": answer("single", FRICTION, strength=1.5),
        "quiet": answer("none"),
        "alarm": answer("none"),
        "strange": answer("unknown", ("cogging", "hip")),
        "fooled": answer("unknown", ("cogging", "hip")),
        "both": answer("two", FRICTION, PRELOAD),
        "broken": answer("single", FRICTION),
    }
    views = {
        "right": view("effect", (FRICTION, 0.9), after=0.3),
        "second": view("effect", (TILT, 0.6), (FRICTION, 0.4)),
        "joint": view("effect", (("quadratic_damping", "knee"), 0.6), (TILT, 0.3)),
        "faint": view("none", (FRICTION, 0.3)),
        "quiet": view("none", (FRICTION, 0.1)),
        "alarm": view("tie", (FRICTION, 0.5), (TILT, 0.4)),
        "strange": view("unknown", (FRICTION, 0.2)),
        "fooled": view("effect", (FRICTION, 0.9)),
        "both": View("effect", ((FRICTION, 0.5), (PRELOAD, 0.4)), (PRELOAD, FRICTION), none=0.0, unknown=0.1),
        "broken": FAILED,
    }
    found = {score.key: score for score in scores(answers, views)}
    assert found["top1"].value == 1 / 4
    assert found["top3"].value == 2 / 4
    assert found["joint"].value == 2 / 4
    assert found["faint"].value == 1.0
    assert found["false_alarm"].value == 1 / 2
    assert found["unknown_flagged"].value == found["unknown_wrong"].value == 1 / 2
    assert found["two_named"].value == found["two_placed"].value == 1.0
    assert found["shrink_median"].count == 5
    assert found["false_alarm"].reached == ""
    assert found["top1"].interval == wilson(1, 4)
    wrong = {name for name in answers if not right(answers[name], views[name])}
    assert wrong == {"second", "joint", "faint", "alarm", "fooled", "broken"}
    cells = Counter(confusion(answers, views))
    assert cells["coulomb_friction", "coulomb_friction"] == cells["coulomb_friction", "failed"] == 1
    assert cells["none", "none"] == cells["none", "coulomb_friction"] == cells["unknown", "unknown"] == 1
    assert sum(cells.values()) == 8


def test_a_tie_is_reported_when_truth_and_a_true_rival_are_named() -> None:
    case = answer("tie", PRELOAD, alike=(TILT, PRELOAD))
    assert reported(case, view("tie", (TILT, 0.5), (PRELOAD, 0.4), tied=((PRELOAD,),)))
    assert not reported(case, view("tie", (FRICTION, 0.5), (PRELOAD, 0.4), tied=((PRELOAD,),)))
    assert not reported(case, view("tie", (TILT, 0.5), (FRICTION, 0.4), tied=((FRICTION,),)))
    assert not reported(case, view("effect", (PRELOAD, 0.5), (TILT, 0.4)))
    table = {score.key: score for score in scores({"a": case}, {"a": view("effect", (PRELOAD, 0.5), (TILT, 0.4))})}
    assert table["tie_reported"].value == 0.0
    assert table["tie_in_top"].value == 1.0


def test_the_gain_is_in_percentage_points() -> None:
    found = gain([True, False, False, False], [True, True, True, False])[0]
    assert found.value == 50.0
    assert found.reached == "goal"
    low, high = found.interval
    assert 0.0 <= low < 50.0 < high <= 100.0


def test_none_and_unknown_are_outcomes_too() -> None:
    views = {
        "a": View("none", ((FRICTION, 0.2),), none=0.7, unknown=0.1),
        "b": View("unknown", (), unknown=0.9, none=0),
    }
    rows = outcome_odds({"a": answer("none"), "b": answer("single", FRICTION)}, views)
    np.testing.assert_allclose(rows, [[0.7, 1.0], [0.9, 0.0]])


@pytest.mark.parametrize(("value", "name"), [(0.31, ""), (0.3, "plain"), (0.05, "strong"), (0.0, "goal")])
def test_levels(value: float, name: str) -> None:
    assert Level(0.30, 0.08, 0.02, most=True).reached(value) == name
    assert Level(math.nan, math.nan, 0.98).reached(0.5) == ""
