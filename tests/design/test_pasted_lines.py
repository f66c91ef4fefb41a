"""The lines that the page offers for the project select the parts beside which they stand."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from typing import Any

import numpy as np
import pytest
import yaml

from synth.design.choose_dampers import DamperOption, MeasuredCurve, choose_dampers
from synth.design.choose_springs import SpringSource, WantedTravel, other_springs, spring_options
from synth.design.page_data import _damper, _spring
from synth.design.pasted_lines import NO_NUMBER, ORDERED
from synth.design.response import WantedRelease, WantedResponse
from synth.errors import UserError
from synth.files.project_options import CadOptions, DamperChoice, JointChoice, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

SPRINGS = """part,vendor,material,included angle [deg],rate [N*m/rad],wire [mm],OD [mm],coils
S-ONE,Mine,music wire,120,1.14,3.2,33,8.1667
"6.4, of wire: 3",Mine,music wire,120,1.10,3.2,33,8.1667
"""
DAMPERS = """part,vendor,direction,continuous,max_torque [N*m],speed [rpm],min_torque [N*m]
D-TWO,Mine,both,yes,0.2,50,
D-CW,Mine,clockwise,yes,0.2,50,
D-RANGE,Mine,both,yes,0.3,50,0.1
"""
LEG = Leg("knee", (Joint("knee", Link(0.3, 0.3, 0.12, 4e-3), pi, 1, None, Spring(1.2, pi), Damper(0.1)),))


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory: pytest.TempPathFactory) -> Catalogue:
    """Only these parts."""
    folder = tmp_path_factory.mktemp("mine")
    for name, text in (("s.csv", SPRINGS), ("d.csv", DAMPERS)):
        (folder / name).write_text(text)
    whole = Catalogue.load([folder / "s.csv", folder / "d.csv"])
    return replace(
        whole,
        springs=tuple(row for row in whole.springs if row.vendor == "Mine"),
        dampers=tuple(row for row in whole.dampers if row.vendor == "Mine"),
    )


def source(catalogue: Catalogue, **spring: Any) -> SpringSource:
    return SpringSource("knee", SpringChoice(**spring), WantedTravel(radians(20.0), 0.1), catalogue, CadOptions())


def dampers(catalogue: Catalogue, curve: MeasuredCurve | None = None, **damper: Any) -> tuple[DamperOption, ...]:
    time = np.linspace(0.0, 0.4, 41)
    release = WantedRelease("a", time, np.array([0.25]), np.zeros(1), Conditions())
    wanted, measured = WantedResponse.of(LEG, [release]), {} if curve is None else {"knee": curve}
    damper = {key: tuple(value) if isinstance(value, list) else value for key, value in damper.items()}
    asked = {"knee": JointChoice(SpringChoice(), DamperChoice(**damper))}
    return choose_dampers(wanted, asked, catalogue, measured, (2.0,)).ranked[0]


def test_a_spring_s_line_selects_as_many_of_it_as_it_says(catalogue: Catalogue) -> None:
    """``2 x S-ONE`` had the line of one, and ``parallel: 2`` beside ``part`` was not heeded."""
    options = other_springs(source(catalogue, parallel=3, make=False), 2.0, [])
    assert {option.label for option in options} >= {"S-ONE", "2 x S-ONE", "3 x S-ONE", "2 x 6.4, of wire: 3"}
    for option in options:
        value = yaml.safe_load(_spring(option)["choice"])
        (again,), _, _ = spring_options(source(catalogue, **value), 2.0)
        assert (again.label, again.rate) == (option.label, option.rate)


def test_a_damper_s_line_selects_its_number_and_gear(catalogue: Catalogue) -> None:
    """Both were dropped, and a pair's line named one of it, which is refused."""
    catalogue = replace(catalogue, dampers=tuple(row for row in catalogue.dampers if row.part != "D-RANGE"))
    options = dampers(catalogue, parallel=2, ratios=[1.0, 2.0])
    named = {option.label: _damper(option)["choice"] for option in options if not _damper(option)["unnamed"]}
    assert named["a pair of D-CW, one each way"] == "{part: D-CW, parallel: 2}"
    assert named["2 x D-TWO, turning 2 times as fast"] == "{part: D-TWO, parallel: 2, ratios: [2.0]}"
    for label in ("D-TWO", "2 x D-TWO", "a pair of D-CW, one each way", "2 x D-TWO, turning 2 times as fast"):
        (again,) = dampers(catalogue, **yaml.safe_load(named[label]))
        assert again.label == label


def test_a_damper_that_no_line_names_has_none_and_says_why(catalogue: Catalogue) -> None:
    ranged = [option for option in dampers(catalogue, part="D-RANGE") if option.row is not None]
    assert len(ranged) > 1
    (own,) = dampers(catalogue, MeasuredCurve(None, DamperCurve((1.0,), (0.1,)), "drops"))
    for option, why in ((ranged[0], ORDERED), (own, NO_NUMBER)):
        shown = _damper(option)
        assert (shown["choice"], shown["unnamed"]) == ("", why)


@pytest.mark.parametrize("number", [1, 3])
def test_one_way_dampers_that_make_no_pairs_are_refused(catalogue: Catalogue, number: int) -> None:
    with pytest.raises(UserError, match=r"D-CW .* one way only.*parallel: 2 .*4 for two pairs"):
        dampers(catalogue, part="D-CW", parallel=number)
