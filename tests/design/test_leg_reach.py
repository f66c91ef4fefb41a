"""A bought spring is drawn with its own body, and chosen only if its legs reach through the caps that clamp them."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import pytest

from cad_joints import cleared
from design.one_joint import LEG, PROJECT
from synth.api.designs import design as design_of
from synth.cad import JointDimensions, LoadDimensions, SpringDimensions
from synth.cad.arm_layout import OVERHANG
from synth.cad.checked_layout import lay_out
from synth.design.bom import _spring_lines
from synth.design.choose_springs import SpringOption
from synth.design.drawable_springs import STOP_ROOM, drawn_pitch, least_leg, reasons_not_drawn
from synth.design.leg_reach import drawn_arm, short_legs
from synth.files.project_options import CadOptions
from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow
from synth.remarks import severity_of

CAD, SHORT = CadOptions(), "its legs end before the caps that would clamp them"
ROW = Catalogue.load().find_spring("LTR135H 10 M")  # wire 3.429, 29.464 outside, 7.17 coils, 120 deg, 2.225 N m/rad


def joint(row: TorsionSpringRow, travel: float) -> JointDimensions:
    """A joint that winds the spring by ``travel`` deg from its free angle to the stop."""
    coil = SpringDimensions(3.429, 26.035, 7.17, 120.0, pitch=drawn_pitch(row))
    stops, loads = (110.0 - travel, 115.0), LoadDimensions(spring_rate=2.224743)
    return cleared(JointDimensions("knee", coil, 110.0, 110.0, range=(stops[0] + 2, 113.0), stops=stops, loads=loads))


@pytest.mark.parametrize("travel", [20.0, 45.0, 65.0])
def test_the_leg_that_a_spring_needs_is_known_before_its_joint_is_drawn(travel: float) -> None:
    """To within a millimetre of the drawn one, along the wire from the coil to the far end of its cap."""
    drawn = joint(ROW, travel)
    whole, needed = drawn_arm(drawn)
    assert whole - needed == pytest.approx(OVERHANG, rel=0.01)
    assert whole == lay_out(drawn).arm_length
    found = least_leg(ROW, radians(travel) - STOP_ROOM, radians(5.0), CAD)
    assert found == pytest.approx(needed * 1e-3, abs=1e-3)


@pytest.mark.parametrize(("length", "drawn"), [(None, True), (0.018, False), (0.080, True)])
def test_a_spring_whose_legs_end_before_their_caps_is_not_chosen(length: float | None, drawn: bool) -> None:
    """One with legs of 18 mm was chosen where arms of 34 mm are drawn."""
    reasons = list(reasons_not_drawn(replace(ROW, leg_length=length), radians(45.0), CAD, radians(5.0)))
    assert reasons == ([] if drawn else [SHORT])


def test_the_page_is_told_of_a_named_spring_with_short_legs_and_the_bill_what_to_cut() -> None:
    drawn = joint(ROW, 45.0)
    whole, needed = drawn_arm(drawn)
    for length, short, cut in (
        (None, False, f", legs cut to {whole:.1f} mm from the coil"),
        (0.018, True, ""),
        (1e-3 * (needed + whole) / 2, False, ""),
        (0.080, False, f", legs of 80 mm cut to {whole:.1f} mm"),
    ):
        option = SpringOption(2.1, 2.0, row=replace(ROW, leg_length=length))
        said = short_legs("knee", option, drawn)
        assert len(said) == short
        assert all(severity_of(text) == "decide" for text in said)
        assert all(f"are 18 mm long, but their caps clamp them up to {needed:.1f} mm" in text for text in said)
        (line,) = _spring_lines("knee", option, drawn)
        assert line.item == f"torsion spring, 2.225 N*m/rad as sold, 2.1 N*m/rad in the joint, right-hand{cut}"
    pair = SpringOption(4.2, 2.0, row=ROW, count=2, mirror=replace(ROW, part="LTL", leg_length=0.018))
    assert [text.partition(" are ")[0] for text in short_legs("knee", pair, drawn)] == ["knee: the legs of LTL"]


@pytest.mark.parametrize(
    ("body", "height"), [(None, 1.03 * 3.429), (0.02794, 1.03 * 3.429), (0.045, (45.0 - 3.429) / 7.17)]
)
def test_a_body_longer_than_touching_coils_is_drawn_so(body: float | None, height: float) -> None:
    """A coil of 45 mm was drawn 25 mm long. Lee's 27.94 mm are 0.07 mm less than eight wires: rounded, close wound."""
    drawn = joint(replace(ROW, body_length=body), 45.0)
    assert lay_out(drawn).coil_height == pytest.approx(drawn.spring.drawn_coils * height)


def test_a_body_that_no_joint_holds_is_no_candidate() -> None:
    (reason,) = reasons_not_drawn(replace(ROW, body_length=0.5), radians(45.0), CAD, radians(5.0))
    assert reason == "cannot be drawn: pitch out of range"


def test_a_design_draws_the_body_and_tells_of_the_legs_of_a_named_part(tmp_path: Path) -> None:
    table = "part,vendor,material,hand,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],"
    table += "body_coils [1],leg_length [mm],body_length [mm]\n"
    (tmp_path / "mine.csv").write_text(table + "SHORT,Mine,music wire,right,120,2.224743,3.429,29.464,7.1667,18,45\n")
    (tmp_path / "one.leg.yaml").write_text(LEG.format(range=""))
    text = PROJECT.format(amplitude=40, frequency=4, spring="part: SHORT")
    (tmp_path / "leg-design.yaml").write_text(text.replace("select: {", "select: {catalogs: [mine.csv], "))
    drawn = design_of(tmp_path / "leg-design.yaml").design.drawn
    assert drawn is not None
    (knee,) = drawn.dimensions.joints
    assert knee.spring.drawn_pitch == pytest.approx((45.0 - 3.429) / 7.1667, rel=1e-4)
    (said,) = [note for note in drawn.notes if "legs of SHORT" in note]
    assert severity_of(said) == "decide"
