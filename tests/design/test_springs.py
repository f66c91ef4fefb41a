"""Choosing springs: a bought one that fits, else one to wind, else the nearest feasible one."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from synth.cad.dimensions import SpringDimensions
from synth.cad.limits import range_problems
from synth.design.choose_dampers import DamperChoiceMade, DamperOption
from synth.design.choose_springs import (
    SpringChoiceMade,
    SpringSource,
    WantedTravel,
    spring_to_wind,
    travels,
)
from synth.design.drawable_springs import drawable_sizes
from synth.design.part_sets import SetsMade, choose_sets
from synth.design.response import WantedRelease, WantedResponse
from synth.design.spring_warnings import sense_warning, spring_warnings
from synth.errors import UserError
from synth.files.project_options import CadOptions, PartsOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.mechanics import rest_pose

TIME = np.linspace(0.0, 1.0, 101)
TRAVEL = [WantedTravel(radians(50.0), radians(10.0))]


def knee(rate: float) -> Leg:
    link = Link(0.3, 0.3, 0.12, 4e-3)
    return Leg("knee alone", (Joint("knee", link, np.pi, 1, None, Spring(rate, radians(111)), Damper(0.1)),))


def wanted(leg: Leg) -> WantedResponse:
    start = leg.to_rotation(np.array([radians(70.0)]))
    return WantedResponse.of(leg, [WantedRelease("a", TIME, start, np.zeros(1), Conditions())])


def choice(**spring: object) -> SpringChoice:
    return SpringChoice(**spring)  # type: ignore[arg-type]


def sets_for(
    leg: Leg, asked: SpringChoice, catalogue: Catalogue, travel: list[WantedTravel], **parts: object
) -> SetsMade:
    """The knee's spring chosen beside a linear damper that was measured."""
    damper = leg.joints[0].damper
    assert damper is not None
    option = DamperOption(None, damper, "curve", "as wanted", spring=leg.joints[0].spring)
    dampers = DamperChoiceMade((option,), ((option,),), ({},), leg, ())
    source = SpringSource("knee", asked, travel[0], catalogue, CadOptions())
    return choose_sets(wanted(leg), leg, dampers, [source], PartsOptions(**parts))  # type: ignore[arg-type]


def choose(
    leg: Leg, asked: SpringChoice, catalogue: Catalogue, travel: list[WantedTravel] = TRAVEL
) -> SpringChoiceMade:
    return sets_for(leg, asked, catalogue, travel).springs


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def test_the_thesis_knee_gets_its_lee_spring(catalogue: Catalogue) -> None:
    leg = knee(2.2922)  # thesis Table 6: wanted after the dampers were measured
    # Its rate as sold is 3 % off, and so the thesis chose it; in the joint, with clamped arms, it is 8 % off.
    limits = choice(
        rate_tolerance=0.1, included_angle=radians(120), max_outer_diameter=0.03175, max_body_length=0.03175
    )
    made = choose(leg, limits, catalogue, TRAVEL)
    assert made.chosen[0].part == "LTR135H 10 M"
    assert rest_pose(made.leg) == pytest.approx(rest_pose(leg), abs=1e-9)
    assert made.left_out[0]  # every other row is counted under a reason


def test_bought_springs_are_ranked_by_response_error_not_by_rate(catalogue: Catalogue) -> None:
    leg = knee(1.55)
    made = choose(leg, choice(rate_tolerance=0.6), catalogue, TRAVEL)
    bought = [option for option in made.ranked[0] if option.row is not None]
    errors = [option.error for option in bought]
    assert len(errors) > 1
    assert errors == sorted(errors)
    nearest = min(bought, key=lambda option: abs(np.log(option.rate / 1.55)))
    assert made.chosen[0].part == nearest.part  # with a single joint and the free angle made to suit


def test_without_a_spring_in_tolerance_one_is_wound_with_a_note(catalogue: Catalogue) -> None:
    leg = knee(3.3)
    made = choose(leg, choice(), catalogue, TRAVEL)
    option = made.chosen[0]
    assert option.design is not None
    assert option.design.feasible
    assert option.rate == pytest.approx(3.3, rel=1e-6)
    assert "no bought spring" in made.warnings[0][0]


def test_a_wound_spring_lasts_the_requested_cycles(catalogue: Catalogue) -> None:
    leg = knee(3.3)
    once, often, longest = (
        choose(leg, choice(make=True, **asked), catalogue).chosen[0].design
        for asked in ({}, {"cycles": 1e6}, {"objective": "life", "max_outer_diameter": 0.05})
    )
    assert once is not None
    assert often is not None
    assert longest is not None
    lives = [each.life.factor_1e6 for each in (once, often, longest) if each.life is not None]
    assert lives[0] < 1.0 <= lives[1] < lives[2]
    assert once.mass < often.mass < longest.mass


def test_a_missing_bought_spring_is_refused_with_the_nearest(catalogue: Catalogue) -> None:
    leg = knee(3.3)
    with pytest.raises(UserError, match=r"knee: none of the \d+ springs.*comes nearest.*make: true"):
        choose(leg, choice(make=False), catalogue, TRAVEL)


def test_the_thesis_hip_spring_is_refused_with_its_stress(catalogue: Catalogue) -> None:
    """79 N m/rad over 45 deg within the thesis' outside diameter: yields; two or more in parallel can."""
    leg = knee(79.35)
    room = choice(make=True, max_outer_diameter=0.0414, max_body_length=0.05)
    travel = [WantedTravel(radians(45.0), radians(15.0))]
    made = choose(leg, room, catalogue, travel)
    said = made.warnings[0][0]
    assert "no single spring can have 79.35 N*m/rad over 45.0 deg" in said
    # With clamped arms and this diameter no stock wire reaches the rate, however short the travel.
    assert "no stock wire of music gives 79.35 N*m/rad with a spring index of" in said
    option = made.chosen[0]
    assert option.design is not None
    assert option.result is not None
    assert option.result.best is None
    assert {item.kind for item in option.result.nearest} == {"parallel"}
    assert option.design.count >= 2
    assert option.rate == pytest.approx(79.35, rel=1e-6)


def test_a_bought_spring_that_would_yield_gives_a_warning(catalogue: Catalogue) -> None:
    leg = knee(0.47269)
    far = [WantedTravel(radians(150.0), 0.0)]
    made = choose(leg, choice(part="LTR080F 10 S"), catalogue, far)
    assert "yields at" in spring_warnings("knee", made.chosen[0], choice(part="LTR080F 10 S"))[0]


def test_travel_is_the_joint_range_or_else_the_motion() -> None:
    leg = knee(1.0)
    motion = leg.to_rotation(np.radians([[100.0], [130.0], [111.0]]))
    found = travels(leg, [motion])[0]
    assert np.degrees([found.winding, found.opening]) == pytest.approx([11.0, 19.0])  # larger angles open it
    ranged = leg.with_joints(knee={"range": (radians(60.0), radians(150.0))})
    found = travels(ranged, [motion])[0]
    assert np.degrees([found.winding, found.opening]) == pytest.approx([51.0, 39.0])


@pytest.mark.parametrize(
    ("asked", "opens", "winds_by", "opens_by"),
    [(None, 10.0, 50.0, 10.0), (80.0, 10.0, 80.0, 10.0), (30.0, 20.0, 30.0, 20.0), (30.0, 40.0, 30.0, 30.0)],
)
def test_a_spring_is_wound_for_its_travel_and_the_stops(
    catalogue: Catalogue, asked: float | None, opens: float, winds_by: float, opens_by: float
) -> None:
    """Stops touch 1.5 deg past a range and the spring yields 2 deg later at the earliest: 3.5 deg more, either way.

    A travel that the project states is that of winding; of the joint's opening it leaves what is no larger.
    """
    wish = choice() if asked is None else choice(travel=radians(asked))
    source = SpringSource("knee", wish, WantedTravel(radians(50.0), radians(opens)), catalogue, CadOptions())
    turned = source.turned
    assert np.degrees([turned.winding, turned.opening]) == pytest.approx([winds_by, opens_by])
    made = spring_to_wind(source, 2.0, lasting=False)[0].design
    assert made is not None
    assert np.degrees([made.travel, made.opening_travel]) == pytest.approx([winds_by + 3.5, opens_by + 3.5])


@pytest.mark.parametrize("rate", [5.0, 40.0, 90.0])
def test_a_spring_of_a_drawn_joint_has_a_size_that_is_drawn(catalogue: Catalogue, rate: float) -> None:
    """A horse's stifle got a coil of 230 mm, then a wire of 12.7 mm, which the drawing refused as the last step."""
    source = SpringSource("knee", choice(), WantedTravel(radians(60.0), radians(10.0)), catalogue, CadOptions())
    made = spring_to_wind(replace(source, drawn=True), rate, lasting=False)[0].design
    assert made is not None
    drawn = SpringDimensions(made.wire_diameter * 1e3, made.mean_diameter * 1e3, made.body_coils, 120.0)
    names = {"wire_diameter", "mean_diameter"}
    assert not names & {problem.dimension for problem in range_problems(drawn)}


def test_a_wire_that_is_not_drawn_but_asked_for_is_taken(catalogue: Catalogue) -> None:
    """The drawing then says what it can draw."""
    wish = drawable_sizes(choice(min_wire_diameter=0.0125))
    assert (wish.min_wire_diameter, wish.max_wire_diameter) == (0.0125, None)


def test_a_spring_that_would_open_is_reversed_with_a_warning() -> None:
    """As the thesis' the arms close towards smaller measured angles; a joint with sign -1 turns the other way in q."""
    leg = knee(1.0)
    motion = np.radians([[0.0], [40.0], [-5.0]])
    for sign, turned_round in ((1, True), (-1, False)):
        turned = replace(leg, joints=(replace(leg.joints[0], sign=sign, zero=radians(111.0)),))
        (found,) = travels(turned, [motion])
        assert np.degrees([found.winding, found.opening]) == pytest.approx([40.0, 5.0])
        assert bool(sense_warning("knee", found)) is found.turned_round is turned_round
    assert "towards larger measured angles" in sense_warning("knee", WantedTravel.of_sides(0.1, 0.7))[0]
    assert WantedTravel.of_sides(0.6, 0.7) == WantedTravel(0.6, 0.7)  # the thesis' seat: larger angles open it
    assert sense_warning("knee", WantedTravel(0.6, 0.7)) == []


@pytest.mark.parametrize("rate", [2.2922, 3.3])  # a bought one, one to wind
def test_the_closing_direction_follows_the_travel(catalogue: Catalogue, rate: float) -> None:
    for travel, closes in ((WantedTravel(0.7, 0.1, turned_round=True), 1), (WantedTravel(0.7, 0.1), -1)):
        made = choose(knee(rate), choice(rate_tolerance=0.05), catalogue, [travel])
        assert {option.closes for option in made.ranked[0]} == {closes}
        assert any("the other way round" in text for text in made.warnings[0]) is (closes == 1)


def test_a_spring_of_unknown_strength_is_reported_unchecked(catalogue: Catalogue) -> None:
    leg = knee(0.47269)
    rows = tuple(
        replace(row, material="unobtainium") if row.part == "LTR080F 10 S" else row for row in catalogue.springs
    )
    unknown = replace(catalogue, springs=rows)
    made = choose(leg, choice(part="LTR080F 10 S"), unknown, TRAVEL)
    said = spring_warnings("knee", made.chosen[0], choice(part="LTR080F 10 S"))[0]
    why = 'material "unobtainium" is not a known wire material'
    assert said == f"knee: it is not known where LTR080F 10 S yields, nor how long it lasts: {why}"
