"""The spring to wind as its joint holds it: stops before its yield either way, limits as drawn, one length of wire."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from design.one_joint import designed
from synth.api.designs import _with_told
from synth.cad.flexed_wire import effective_length
from synth.design.bom import write_bom
from synth.design.coil_room import arbor_of
from synth.design.drawn_remedies import remedy_of
from synth.design.drawn_springs import draw_up, seats_set
from synth.design.drawn_travel import yields_of
from synth.design.joint_sizing import dimensions_of
from synth.design.leg_design import LegDesign
from synth.design.measured_rate import rate_in_joint
from synth.design.page_data import page_json
from synth.design.solid_files import joint_travel, not_weighed
from synth.design.spring_entry import spring_entry
from synth.design.spring_warnings import spring_warnings
from synth.design.write_design import design_json
from synth.files.project_options import CadOptions, MeasuredSpring, SpringChoice, ToleranceOptions
from synth.parts.catalogs import Catalogue
from synth.remarks import Remark, decisive, noted, severity_of
from synth.reports.sections.winding_plan import winding_of
from synth.spring.nearest_springs import NearestSpring
from synth.spring.spring_task import SpringLimits
from synth.spring.stress import bending_stress
from synth.spring.winding_sheet import request_lines, winding_sheet
from synth.swing.leg_model import Damper, DamperCurve

RANGE = (132, 215)  # deg, of the knee


@pytest.fixture(scope="module")
def wound(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    return designed(tmp_path_factory.mktemp("wound"), between=RANGE)


@pytest.fixture(scope="module")
def bought(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    return designed(tmp_path_factory.mktemp("bought"), "part: 9271K589", between=RANGE)


def test_the_drawn_spring_has_the_arms_and_pitch_of_its_joint(wound: LegDesign) -> None:
    made, drawn = wound.springs.chosen[0].design, wound.drawn
    assert made is not None
    assert drawn is not None
    spring = drawn.dimensions.joints[0].spring
    assert made.clamped_arm == pytest.approx(spring.free_arm * 1e-3)
    assert made.peak_moment > 1.02 * made.moment
    body = spring.wire_diameter + spring.drawn_pitch * made.body_coils
    assert made.body_length == pytest.approx(body * 1e-3)
    assert made.wound_body_length > made.body_length


def test_the_warning_states_the_coil_that_is_to_be_wound(wound: LegDesign) -> None:
    """The nearest spring's arms are those of its drawn joint; sentence and ``nearest`` had those of the search."""
    option = wound.springs.chosen[0]
    assert option.design is not None
    assert option.result is not None
    searched = replace(option.design, active_coils=0.98 * option.design.active_coils)  # as with shorter arms
    taken = NearestSpring("parallel", "2 in parallel: ", searched)
    result = replace(option.result, best=None, nearest=(NearestSpring("more_room", "more: ", searched), taken))
    springs = replace(wound.springs, chosen=(replace(option, design=searched, result=result),))
    design = draw_up(replace(wound, springs=springs), Catalogue.load())
    made = spring_entry(design.springs.chosen[0])
    assert made["make"]["mean_diameter"]["value"] != pytest.approx(searched.mean_diameter * 1e3, rel=0.01)
    assert made["nearest"][1]["make"] == made["make"]
    assert made["nearest"][0]["make"]["mean_diameter"]["value"] == pytest.approx(searched.mean_diameter * 1e3)
    (said,) = (text for text in design.springs.warnings[0] if "no single spring" in text)
    for text in (said, made["nearest"][1]["text"]):
        assert f"mean diameter {made['make']['mean_diameter']['value']:.4g} mm" in text
    turned = [f"{made['make'][key]['value']:.1f} deg" for key in ("travel", "opening_travel")]
    assert "wound by up to {} and opened by {}".format(*turned) in said
    assert severity_of(said) == "decide"


def test_the_sheet_gives_the_rate_that_a_maker_measures(wound: LegDesign) -> None:
    """Pins at l from the coil bend each arm as a cantilever: rate = EI/(pi D Nb + 2 l/3); the joint's is EI/L_eff."""
    made, drawn = wound.springs.chosen[0].design, wound.drawn
    assert made is not None
    assert drawn is not None
    spring, mean, distance = drawn.dimensions.joints[0].spring, made.mean_diameter, made.test.distances[0]
    assert spring.free_arm is not None
    stiff = effective_length(mean * 500, made.body_coils, spring.free_arm) * 1e-3
    expected = made.rate * stiff / (math.pi * mean * made.body_coils + 2 * distance / 3)
    assert made.test.rate == pytest.approx(expected)
    assert made.test.rate > 1.01 * made.rate
    assert spring.free_arm * 1e-3 < distance < made.leg_lengths[0]
    assert made.load_points[1].torque == pytest.approx(expected * made.travel)
    shown = winding_of(made.as_json())
    assert float(shown["torques"][-1]["torque"].split()[0]) == pytest.approx(expected * made.travel, abs=6e-4)
    assert shown["in_joint"]["value"] == pytest.approx(made.rate)
    for text in ("\n".join(request_lines(made)), winding_sheet(made)):
        assert f"Rate in this test{':' * ('REQUEST' in text)} {expected:.4g} N*m/rad" in text
        assert f"{distance * 1e3:.4g} mm from the coil" in text
        assert f"{made.rate:.4g} N*m/rad" in text
    assert "measured in the assembled joint" in shown["steps"][-1]  # not the angle between the loose arms
    arms = made.as_json()["arms"]
    assert "force" not in arms
    assert arms["axis_force"]["value"] < 0.5 * made.moment / made.leg_lengths[0]


def test_the_quotation_states_the_travel_to_the_joint_s_stops(wound: LegDesign) -> None:
    """It stated the working travel alone, 33 deg, of a spring that the stops let turn by 39 deg."""
    option, drawn = wound.springs.chosen[0], wound.drawn
    made = option.design
    assert made is not None
    assert drawn is not None
    joint = drawn.dimensions.joints[0]
    (low, high), free = joint.stop_angles, joint.free_angle
    assert joint.closes == -1
    works = f"Works {math.degrees(made.travel):.4g} deg closing, {math.degrees(made.opening_travel):.4g} deg opening"
    stops = f"; at the joint's stops {free - low:.4g} deg closing, {high - free:.4g} deg opening"
    (found,) = [each for each in request_lines(made, joint=joint_travel(option, joint)) if each.startswith("Works")]
    assert found == works + stops


def test_only_coils_without_a_gap_are_said_to_touch(wound: LegDesign) -> None:
    """The body's length on the sheet, d + p N, is that of the coils as described beside it."""
    made = wound.springs.chosen[0].design
    assert made is not None
    gap = (made.body_length / made.wire_diameter - 1.0) / made.body_coils * made.wire_diameter - made.wire_diameter
    assert gap == pytest.approx(0.03 * made.wire_diameter)
    touching = replace(made, pitch=1.0, body_length=made.wire_diameter * (1.0 + made.body_coils))
    for spring, said in ((made, f"{gap * 1e3:.2g} mm "), (touching, "touching")):
        sheet, order = winding_sheet(spring), "\n".join(request_lines(spring))
        for text in (sheet, order, winding_of(spring.as_json())["steps"][1].replace("\xa0", " ")):
            assert said in text
            assert ("touching" in text) is (spring is touching)
    assert f"pitch 1.03 x wire, coils {gap * 1e3:.2g} mm apart" in winding_sheet(made)


def test_the_sheet_s_table_is_the_torque_of_the_loose_spring(wound: LegDesign) -> None:
    """T = E I angle / (pi D N + 2 l/3), each arm a cantilever to its pin; in the joint the spring is 2.5 % softer."""
    made = wound.springs.chosen[0].design
    assert made is not None
    below = winding_sheet(made).partition("angle [deg]  torque [N*m]\n")[2].splitlines()[:4]
    table = np.array([[float(cell) for cell in line.split()] for line in below])
    bending = 193e9 * math.pi * made.wire_diameter**4 / 64  # Shigley, table 10-5: music wire above 0.125 in
    length = math.pi * made.mean_diameter * made.body_coils + 2 * made.test.distances[0] / 3
    assert table[:, 0] == pytest.approx(math.degrees(made.travel) * np.array([0.25, 0.5, 0.75, 1.0]), rel=1e-3)
    assert table[:, 1] == pytest.approx(bending * np.radians(table[:, 0]) / length, rel=1e-3)
    assert made.test.rate > 1.02 * made.rate


@pytest.mark.parametrize(
    ("damper", "torque"),
    [
        (Damper(0.12), 0.30),
        (Damper(curve=DamperCurve((1.0, 4.0), (0.2, 0.5))), 0.35),
        (Damper(curve=DamperCurve((0.5, 2.0), (0.2, 0.5))), 0.60),
    ],
)
@pytest.mark.parametrize("count", [1, 2])
def test_a_joint_bears_all_its_springs_and_the_damper_at_the_fastest_swing(
    wound: LegDesign, damper: Damper, torque: float, count: int
) -> None:
    """Half a radian at 5 rad/s swings at up to 2.5 rad/s; the springs' rates, E I over the bent length, add up."""
    option, joint = wound.springs.chosen[0], wound.built.joints[0]
    made, drawn = option.design, wound.drawn
    assert made is not None
    assert drawn is not None
    assert joint.spring is not None
    free = drawn.dimensions.joints[0].spring.free_arm
    assert free is not None
    length = effective_length(made.mean_diameter * 500, made.body_coils, free) * 1e-3
    rate = count * 193e9 * math.pi * made.wire_diameter**4 / 64 / length
    held = replace(joint, damper=damper, spring=replace(joint.spring, rate=count * option.rate))
    springs = replace(wound.springs, chosen=(replace(option, design=replace(made, count=count)),))
    built = replace(wound.built, joints=(held,))
    swings = tuple(0.5 * np.sin(5.0 * release.time)[:, None] for release in wound.wanted.releases)
    loads = dimensions_of(replace(wound, springs=springs, built=built, built_motions=swings)).dimensions.joints[0].loads
    assert loads.spring_rate == pytest.approx(rate, rel=1e-3)
    assert loads.damper_torque == pytest.approx(torque, rel=2e-3)  # of speeds between samples


def test_a_measured_rate_is_converted_into_the_joints(wound: LegDesign, bought: LegDesign) -> None:
    made = wound.springs.chosen[0].design
    assert made is not None
    for rate, held, factor in (
        (1.02 * made.test.rate, {}, 1.02),
        (made.test.rate_at(0.0, made.body_coils, made.mean_diameter), {"rate_distance": 0.0}, 1.0),
        (0.97 * made.rate, {"rate_held": "joint"}, 0.97),
    ):
        measured = {"knee": MeasuredSpring(rate=rate * made.count, **held)}
        design, seats = seats_set(replace(wound, project=replace(wound.project, measured_springs=measured)))
        assert seats == {}  # what the seat must make up for is not known before the free angle
        assert design.built.spring_rate[0] == pytest.approx(factor * made.rate * made.count)
    option = bought.springs.chosen[0]
    assert option.row is not None
    assert option.row.rate is not None
    assert spring_entry(option)["test"]["rate"]["value"] < option.row.rate
    at_the_coil = MeasuredSpring(rate=option.row.rate * option.count, rate_distance=0.0)
    assert rate_in_joint(at_the_coil, option) == pytest.approx(option.rate, rel=0.01)  # of a count of coils as drawn
    not_drawn = replace(option, loose=None)
    assert rate_in_joint(replace(at_the_coil, rate_distance=None), not_drawn) == pytest.approx(option.rate)


def test_a_measured_rate_beyond_its_tolerance_is_told(wound: LegDesign) -> None:
    """A slip of a factor 23 passed, and the page's first table kept the designed rate."""
    designed = wound.springs.chosen[0].rate
    for off, told in ((1.01, False), (0.5, True)):
        known = {"knee": MeasuredSpring(rate=off * designed, rate_held="joint")}
        design, _ = seats_set(replace(wound, project=replace(wound.project, measured_springs=known)))
        assert [joint for joint, text in design.warnings if "the measured spring has" in text] == ["knee"] * told
        spring = design_json(design, [], Path(), {})["joints"]["knee"]["spring"]
        assert spring["measured_rate"]["value"] == pytest.approx(off * designed)
    assert "measured_rate" not in design_json(wound, [], Path(), {})["joints"]["knee"]["spring"]


def test_the_forecast_is_that_of_the_springs_in_hand(wound: LegDesign) -> None:
    """Of one joint whose spring is measured nothing of its tolerance is left: both forecasts are the measured one."""
    spring = wound.built.joints[0].spring
    assert spring is not None
    asked = ToleranceOptions(rate=0.0, free_angle=math.radians(10.0), torque=0.0, measured=0.0, temperature=0.0)
    project = replace(wound.project, parts=replace(wound.project.parts, tolerance=asked))

    def measured(off: float) -> LegDesign:
        known = {"knee": MeasuredSpring(free_angle=spring.free_angle + math.radians(off))}
        return seats_set(replace(wound, project=replace(project, measured_springs=known)))[0]

    seated, beyond = measured(5.0), measured(30.0)
    assert seated.sets.chosen.forecast == seated.sets.measured
    low, high = np.degrees(seated.sets.chosen.forecast.interval90)
    assert high - low < 1.0
    assert seated.sets.chosen.forecast.expected < 0.5 * wound.sets.chosen.forecast.expected
    assert beyond.sets.chosen.forecast.nominal == pytest.approx(np.sqrt(np.mean(beyond.errors**2)), rel=0.01)
    assert beyond.sets.chosen.forecast.nominal > 2.0 * seated.sets.chosen.forecast.nominal
    by_rate = {"knee": MeasuredSpring(rate=1.1 * wound.springs.chosen[0].rate, rate_held="joint")}
    design = seats_set(replace(wound, project=replace(project, measured_springs=by_rate)))[0]
    assert design.sets.chosen.forecast.expected > 1.5 * design.sets.measured.expected  # its free angle is unknown
    assert design_json(seated, [], Path(), {})["response"]["free_angles_measured"] == ["knee"]
    assert design_json(design, [], Path(), {})["response"]["free_angles_measured"] == []


def test_what_makes_the_leg_useless_comes_before_numbers_in_doubt(wound: LegDesign) -> None:
    """A damper that slips as drawn, and masses that a run without drawing lacks: both above three boxes of the page."""
    assert design_json(wound, [], Path(), {})["joints"]["knee"]["damper"]["slips"]
    doubt = {"joint": "knee", "text": "knee: a law is assumed", "severity": "decide"}
    order = [item["text"] for item in _with_told([doubt], [noted("a note"), decisive("it slips")])]
    assert order == ["it slips", "knee: a law is assumed", "a note"]
    first, text = not_weighed(replace(wound, drawn=None)).warnings[0]
    assert first is None
    assert "links of knee are taken as the target states them" in text
    assert severity_of(text) == "decide"


def test_stops_keep_the_yield_of_each_direction(wound: LegDesign) -> None:
    """Smaller angles close this spring. Opening, it may bear 70/85 of the stress."""
    option, spring = wound.springs.chosen[0], wound.built.joints[0].spring
    made = option.design
    assert made is not None
    assert spring is not None
    yields, free = yields_of(wound, 0), math.degrees(spring.free_angle)
    assert yields == pytest.approx(
        (free - math.degrees(made.free_travel), free + math.degrees(made.free_opening_travel))
    )
    assert made.load.stress(-made.free_opening_travel) == pytest.approx(70 / 85 * made.yield_stress)
    turned = replace(wound, springs=replace(wound.springs, chosen=(replace(option, closes=1),)))
    other = yields_of(turned, 0)
    assert other is not None
    assert (free - other[0], other[1] - free) == pytest.approx((yields[1] - free, free - yields[0]))


def test_a_bought_spring_yields_as_its_joint_holds_it(bought: LegDesign) -> None:
    """The vendor's rate and a uniform moment are those of a body whose arms are free."""
    option = bought.springs.chosen[0]
    row, check, drawn = option.row, option.check, bought.drawn
    assert row is not None
    assert check is not None
    assert drawn is not None
    assert check.rate == pytest.approx(option.rate / option.count)
    assert check.clamped_arm == pytest.approx(drawn.dimensions.joints[0].spring.free_arm * 1e-3)
    assert row.rate is not None
    plain = replace(check, rate=row.rate, clamped_arm=None)
    bent = check.rate * check.free_travel * check.load.ratios(check.free_travel).coil
    assert bent == pytest.approx(plain.rate * plain.free_travel)
    assert check.free_opening_travel < 0.97 * plain.free_opening_travel
    assert not [text for text in spring_warnings("knee", option, SpringChoice()) if "yields" in text]
    opened = replace(check, opening_travel=1.01 * check.free_opening_travel)
    assert "opens it" in spring_warnings("knee", replace(option, check=opened), SpringChoice())[0]


def test_a_limit_that_only_the_drawn_spring_violates_is_a_warning(wound: LegDesign) -> None:
    made, result = wound.springs.chosen[0].design, wound.springs.chosen[0].result
    assert made is not None
    assert result is not None
    assert wound.drawn is not None
    assert not any("as its joint holds it" in note for note in wound.drawn.notes)
    limits = replace(result.wish.limits, max_outer_diameter=0.99 * made.outer_diameter)
    asked = replace(result, wish=replace(result.wish, limits=limits))
    springs = replace(wound.springs, chosen=(replace(wound.springs.chosen[0], result=asked),))
    again = draw_up(replace(wound, springs=springs), Catalogue.load()).drawn
    assert again is not None
    said = [note for note in again.notes if "as its joint holds it" in note]
    assert len(said) == 1
    assert re.match(r"knee: the spring to wind, as its joint holds it, has outer diameter [\d.]+ mm, allowed", said[0])
    assert severity_of(said[0]) == "decide"
    assert isinstance(said[0], Remark)
    assert said[0].remedy == "Ask for somewhat less max_outer_diameter than you need under select.joints.knee.spring."


def test_the_remedy_of_a_coil_too_narrow_for_the_shaft_names_the_shaft() -> None:
    """The remedy for all limits was more travel or cycles, or less length or diameter, which nobody had asked for."""
    cad = CadOptions(shaft_diameter=8e-3, clearance=0.4e-3)
    limits = SpringLimits(arbor_diameter=arbor_of(cad))
    said = remedy_of("d", ["arbor"], limits, cad)
    assert said.startswith(
        "The coil at full travel must leave 9.778 mm for the shaft: make cad.shaft_diameter (8 mm) or "
    )
    assert "cad.clearance (0.4 mm)" in said
    assert "cycles" not in said


def test_order_and_winding_plan_have_one_length_of_wire(wound: LegDesign, tmp_path: Path) -> None:
    """A tenth more than the spring was to be cut, 60 mm more to be ordered: too short above 600 mm of wire."""
    made = wound.springs.chosen[0].design
    assert made is not None
    write_bom(wound, [], {}, tmp_path / "bom.csv")
    with (tmp_path / "bom.csv").open(newline="") as stream:
        line = next(row for row in csv.DictReader(stream) if row["how"] == "wind")
    assert float(line["length [mm]"]) == pytest.approx(made.cut_length * 1e3, abs=0.51)
    assert made.cut_length == pytest.approx(made.wire_length + 0.060)
    cut = winding_of(made.as_json())["steps"][0]
    assert cut.startswith(f"Cut {line['length [mm]']} mm of music wire")


def test_the_page_shows_the_peak_stress(wound: LegDesign) -> None:
    made = wound.springs.chosen[0].design
    assert made is not None
    shown = page_json(wound)["joints"]["knee"]["springs"][0]["stress_per_torque"] * made.largest_moment
    assert shown == pytest.approx(max(made.stress, made.opening_stress) * 1e-6, rel=1e-6)
    assert shown > 1.02e-6 * bending_stress(made.largest_moment, made.wire_diameter, made.mean_diameter)
