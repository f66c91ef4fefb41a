"""What a console shows of results and inputs: some lines, never all samples."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import synth
from synth.api.report import Report
from synth.reports.notebook import notebook_text

EXAMPLES = Path(synth.__file__).parent / "examples"
MOST = 1100  # characters: a dozen lines


def results() -> Iterator[type[Report]]:
    """All classes of public results."""
    for name in synth._PUBLIC:
        made = getattr(synth, name)
        if isinstance(made, type) and issubclass(made, Report):
            yield made


@pytest.fixture(scope="module")
def shown() -> dict[str, Any]:
    """One of each kind that is made in seconds."""
    leg = synth.read_leg(EXAMPLES / "fit" / "robot.leg.yaml")
    trials = synth.read_trials(["trials/free_*.csv"], leg, folder=EXAMPLES / "fit")
    fitted = synth.fit(leg, trials)
    made: tuple[Any, ...] = (leg, trials[0], trials, fitted, synth.compare({"a": fitted, "b": fitted}),
            synth.spring(1.7, 0.7), synth.Catalogue.load(), synth.FitOptions(), synth.FitSettings(), synth.Tolerance(),
            synth.RatePrior(), fitted.joints["knee"])  # fmt: skip
    return {type(each).__name__: each for each in made}


def test_no_result_lists_its_samples(shown: dict[str, Any]) -> None:
    """A fit of three short trials was 253 thousand characters, the catalogues 590 thousand."""
    assert {name: len(repr(each)) for name, each in shown.items() if len(repr(each)) > MOST} == {}
    assert {made.__name__ for made in results()} == {"Compared", "Design", "Fit", "Gap", "Hopper", "JumpGap",
                                                     "SpringAnswer"}  # fmt: skip
    for made in results():
        assert made.__repr__ is Report.__repr__, made


def test_a_result_is_its_headline_and_a_table(shown: dict[str, Any]) -> None:
    fitted, text = shown["Fit"], repr(shown["Fit"])
    assert len(repr(fitted.result)) < 15_000  # without its trials' samples: 230 000 with them
    first, heads, *rows, last = text.splitlines()
    assert first == f"Fit: {fitted.headline}"
    assert heads.split("  ")[0] == "joint"
    assert [row.split()[0] for row in rows] == ["hip", "knee", "ankle"]
    assert last == "and 7 more columns: to_frame()"
    assert max(map(len, text.splitlines()[1:])) <= 100
    assert repr(shown["Compared"]).splitlines()[-1].endswith(" more rows: to_frame()")


@pytest.mark.parametrize(
    ("columns", "lines"),
    [
        ({}, []),
        ({"a": []}, []),
        ({"a": [1.23456, None], "b [m]": [True, "x\ny"]}, ["a      b [m]", "1.235    yes", "–        x y"]),
    ],
)
def test_tables_of_any_size(columns: dict[str, list[Any]], lines: list[str]) -> None:
    assert notebook_text("head", columns).splitlines() == ["head", *lines]


def test_a_trial_shows_its_size_and_conditions(shown: dict[str, Any]) -> None:
    assert repr(shown["Trial"]) == "Trial('trials/free_1.csv', 121 samples of 3 joints, 1.2 s)"
    time, angles = np.arange(5) / 10.0, np.zeros((5, 1))
    made = synth.Trial("a", time, angles, velocities=angles, locked=("knee",), tip_mass=0.1, tilt=np.pi / 2.0,
                       held_out=True, leg=shown["Leg"])  # fmt: skip
    words = "velocities, knee locked, tip mass 0.1 kg, tilt 90 deg, held out, its own leg"
    assert repr(made) == f"Trial('a', 5 samples of 1 joint, 0.4 s, {words})"


@pytest.mark.parametrize(
    ("time", "angles", "said"),
    [
        ([0, 1, 2], [[0], [1]], "time (3,) and angles (2, 1) do not match"),
        ([0, 1], [[0], [1, 2]], "time and angles are not arrays of numbers"),
        (None, "x", "time and angles are not arrays of numbers"),
        ([], np.zeros((0, 2)), "0 samples of 2 joints"),
    ],
)
def test_a_trial_that_is_none_is_shown_without_an_error(time: Any, angles: Any, said: str) -> None:
    """It is refused where it is used; a debugger shows it before."""
    assert repr(synth.Trial("a", time, angles)) == f"Trial('a', {said})"
