"""Dampers and links for which no joint can be drawn are told before anything is chosen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from synth.api.design_input import read_design
from synth.api.designs import design
from synth.design.drawable_dampers import reasons_in
from synth.errors import UserError
from synth.files.leg_project import LegProject
from synth.files.project_options import CadOptions, DamperShape
from synth.parts.catalogs import Catalogue

HEADER = (
    "part,vendor,direction,continuous,max_torque [N*m],speed [rpm],outer_diameter [mm],body_length [mm],"
    "bolt_circle [mm],bolts [1],bolt_diameter [mm],shaft_side,shaft_form,shaft_size [mm]\n"
)
ROWS = {
    "SMALL": "0.2,50,11,12,16,2,2.4,bore,square,3",  # on the shaft of 8 mm neither screws nor bore fit
    "THIN BORE": "0.2,50,40,18,52,4,3.4,bore,round,4",
    "LOOSE": "0.2,50,40,18,52,4,3.4,bore,round,8",
    "FLAT": "0.2,50,40,4,52,4,3.4,bore,square,5.6",
    "WIDE": "0.2,50,90,18,110,4,3.4,bore,square,5.6",
    "GOOD": "0.2,50,40,18,52,4,3.4,bore,square,5.6",
    "OWN SHAFT": "0.2,50,40,18,52,4,3.4,shaft,d,6",
}
LEG = """kind: leg
name: one link
gravity: 9.81 m/s^2
joints:
  - name: knee
    zero: 180 deg
    sign: +1
    link: {{length: {length} mm, mass: {mass} g, com: {com} mm, inertia: {inertia} kg*m^2}}
"""
PROJECT = """kind: leg-design
name: one link
source:
  leg: one.leg.yaml
  wanted: {{knee: {{rest: 170 deg, amplitude: 30 deg, damping_ratio: 0.3, damped_frequency: 6 Hz}}}}
target: one.leg.yaml
select: {{catalogs: [mine.csv], vendors: [Mine, McMaster-Carr], without: [6597K8, 6597K19, 6597K21]}}
{cad}
"""


def catalogue(folder: Path, *parts: str) -> Catalogue:
    rows = "".join(f"{name},Mine,both,yes,{ROWS[name]}\n" for name in parts)
    (folder / "mine.csv").write_text(HEADER + rows, encoding="utf-8")
    return Catalogue.load([folder / "mine.csv"])


def project(folder: Path, length: float, cad: str = "") -> LegProject:
    sizes = {"length": length, "mass": 2.0 * length, "com": 0.45 * length, "inertia": 2e-3 * length**3 * 1e-6 / 12}
    (folder / "one.leg.yaml").write_text(LEG.format(**sizes))
    (folder / "leg-design.yaml").write_text(PROJECT.format(cad=cad))
    return read_design(folder / "leg-design.yaml")[0]


def test_reasons_name_the_shaft_and_what_does_not_fit(tmp_path: Path) -> None:
    found = catalogue(tmp_path, *ROWS)
    leg = project(tmp_path, 90.0).target
    rows = {row.part: row for row in found.dampers if row.part in ROWS}
    against = reasons_in(leg, CadOptions())
    told = {name: against(0, row) for name, row in rows.items()}
    assert told["GOOD"] is None
    assert told["OWN SHAFT"] is None
    assert told["SMALL"] == (
        "its circle of screws is too small for the shaft of 8 mm (cad.shaft_diameter) and the damper's bracket"
    )
    assert told["THIN BORE"] == "nothing is known to hold the shaft in its round bore (cad.dampers.knee.hub)"
    assert told["LOOSE"] == told["THIN BORE"]
    assert told["FLAT"] == "its body is too short for the screws of the bracket"
    assert told["WIDE"] == ("its bracket is too wide for the link of 90 mm beside it (cad.dampers.knee.bolt_circle)")
    held = CadOptions(dampers={"knee": DamperShape(hub="clamp")})
    assert reasons_in(leg, held)(0, rows["LOOSE"]) is None
    assert reasons_in(leg, held)(0, rows["THIN BORE"]) == "its bore does not fit the shaft of 8 mm (cad.shaft_diameter)"
    thin = CadOptions(shaft_diameter=0.003)
    assert (
        reasons_in(leg, thin)(0, rows["SMALL"])
        == "its circle of screws is too small for the shaft of 3 mm (cad.shaft_diameter) and the damper's bracket"
    )


def test_a_stated_size_that_cannot_be_is_left_to_the_drawing_which_names_its_key(tmp_path: Path) -> None:
    found = catalogue(tmp_path, "GOOD")
    (row,) = (row for row in found.dampers if row.part == "GOOD")
    leg = project(tmp_path, 150.0).target
    for shape in (DamperShape(bolt_circle=0.3), DamperShape(bolt_circle=0.04), DamperShape(outer_diameter=0.2)):
        assert reasons_in(leg, CadOptions(dampers={"knee": shape}))(0, row) is None
    wide = replace(row, outer_diameter=0.2, bolt_circle=0.19)
    assert reasons_in(leg, CadOptions())(0, wide) == "cannot be drawn: its outer diameter is out of range"
    stated = "cad: {dampers: {knee: {bolt_circle: 300 mm}}}"
    with pytest.raises(UserError, match=r"cad\.dampers\.knee\.bolt_circle: 300 mm: allowed is "):
        design(project(tmp_path, 150.0, stated), found)


def test_a_damper_that_can_be_drawn_is_chosen_of_nearer_ones_that_cannot(tmp_path: Path) -> None:
    """The four before it have the same law and a smaller or an impossible place on the shaft of 8 mm."""
    found = catalogue(tmp_path, "SMALL", "THIN BORE", "FLAT", "WIDE", "GOOD")
    made = design(project(tmp_path, 90.0), found).design
    assert made.dampers.labels == ("GOOD",)
    assert sum(made.dampers.left_out[0].values()) >= 4
    assert made.drawn is not None
    alone = catalogue(tmp_path, "SMALL")
    plain = design(project(tmp_path, 150.0), alone, solids=False).design
    assert plain.dampers.labels == ("SMALL",)  # nothing is drawn


def test_where_no_damper_can_be_drawn_the_reasons_are_counted(tmp_path: Path) -> None:
    found = catalogue(tmp_path, "SMALL", "FLAT")
    with pytest.raises(UserError, match="knee: no damper in the catalogue meets the constraints") as refused:
        design(project(tmp_path, 150.0), found)
    text = str(refused.value)
    assert "1 its circle of screws is too small for the shaft of 8 mm (cad.shaft_diameter)" in text
    assert "1 its body is too short for the screws of the bracket" in text


def test_a_link_too_short_for_any_joint_is_refused_at_once_with_the_least(tmp_path: Path) -> None:
    small = "cad: {shaft_diameter: 3 mm, wall: 1.2 mm, clearance: 0.1 mm, link_width: 6 mm, tube_wall: 0.5 mm}"
    found = catalogue(tmp_path, "GOOD")
    with pytest.raises(UserError) as refused:
        design(project(tmp_path, 20.0, small), found)
    text = str(refused.value)
    assert "the link of knee is 20 mm long: allowed is at least 28 mm, which its hinge and the tube's socket" in text
    assert "no joint can be drawn in it" in text
    with pytest.raises(UserError, match=r"Smaller sizes can do it, down to cad: \{shaft_diameter: 3 mm, wall: 1.2 mm"):
        design(project(tmp_path, 40.0), found)
    assert design(project(tmp_path, 20.0), found, solids=False).design.dampers.labels == ("GOOD",)
