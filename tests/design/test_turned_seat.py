"""A spring is turned round where only the other seat holds the wanted travel; where neither does, the joint fails."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from design.one_joint import designed
from synth.cad.checks import check_arms
from synth.cad.joint import build_joint
from synth.cad.travel import Bodies, check_travel
from synth.design.drawn_springs import draw_up
from synth.design.drawn_travel import yields_of
from synth.design.leg_design import LegDesign
from synth.design.write_design import design_json
from synth.parts.catalogs import Catalogue


@pytest.fixture(scope="module")
def bought(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    return designed(tmp_path_factory.mktemp("bought"), "part: 9271K589", frequency=2)


def with_range(design: LegDesign, below: float, above: float) -> LegDesign:
    """Drawn for a stated range that ends this far below and above the free angle, deg; seated as the thesis'."""
    spring, option = design.built.joints[0].spring, replace(design.springs.chosen[0], closes=-1, turned_to_hold=False)
    assert spring is not None
    ends = (spring.free_angle - math.radians(below), spring.free_angle + math.radians(above))
    target = replace(design.project.target, joints=(replace(design.project.target.joints[0], range=ends),))
    springs = replace(design.springs, chosen=(option,))
    return draw_up(replace(design, project=replace(design.project, target=target), springs=springs), Catalogue.load())


def test_a_spring_is_turned_round_where_only_the_other_seat_holds_the_travel(bought: LegDesign) -> None:
    """It was drawn with a stop beyond yield, and the message said that both are not possible together."""
    check = bought.springs.chosen[0].check
    assert check is not None
    winds, opens = (math.degrees(angle) for angle in (check.free_travel, check.free_opening_travel))
    assert opens + 10.0 < winds
    turned = with_range(bought, opens - 8.0, opens + 4.0)
    assert turned.drawn is not None
    dimensions = turned.drawn.dimensions.joints[0]
    free = dimensions.free_angle
    assert turned.springs.chosen[0].closes == dimensions.closes == 1
    assert dimensions.yields == pytest.approx((free - opens, free + winds), abs=0.3)  # as the drawn arms hold it
    as_seated = turned.springs.chosen[0].check
    assert as_seated is not None  # what wound it opens it
    assert (as_seated.travel, as_seated.opening_travel) == (check.opening_travel, check.travel)
    assert as_seated.stress > as_seated.opening_stress
    assert check.stress < check.opening_stress
    low, high = dimensions.stop_angles
    assert dimensions.closing(high) == pytest.approx(opens + 5.5, abs=0.1)  # larger angles close the arms
    assert low - dimensions.yields[0] > 2.0
    offset = math.remainder(free + dimensions.spring.included_angle - dimensions.upper_arm_angle, 360.0)
    written = design_json(turned, [], Path(), {})["joints"]["knee"]["arm_offset"]["value"]
    assert written == pytest.approx(offset)
    assert any("larger measured angles close its arms" in note for note in turned.drawn.notes)
    assert not any("not possible together" in note for note in turned.drawn.notes)
    joint = build_joint(dimensions)
    checks = [*check_arms(joint), *check_travel(Bodies(joint))]
    assert "stops before yield" in {check.name for check in checks}
    assert [str(check) for check in checks if not check.passed] == []


def test_a_seat_that_holds_the_travel_is_kept(bought: LegDesign) -> None:
    kept = with_range(bought, 50.0, 55.0)
    assert kept.springs.chosen[0].closes == -1
    assert kept.drawn is not None
    assert not any("close its arms" in note for note in kept.drawn.notes)


def test_a_joint_whose_spring_yields_in_either_seat_fails_its_check(bought: LegDesign) -> None:
    """Its yield was forgotten, so that the check "stops before yield" was left out, and the solids were exported."""
    check = bought.springs.chosen[0].check
    assert check is not None
    opens = math.degrees(check.free_opening_travel)
    drawn = with_range(bought, opens + 3.0, opens + 4.0)
    assert drawn.drawn is not None
    assert any("nor with the spring seated the other way round" in note for note in drawn.drawn.notes)
    dimensions = drawn.drawn.dimensions.joints[0]
    assert dimensions.yields == yields_of(drawn, 0)
    gates = [each for each in check_travel(Bodies(build_joint(dimensions))) if each.name == "stops before yield"]
    assert [gate.passed for gate in gates] == [False]
    assert gates[0].value == pytest.approx(-5.5, abs=0.3)
