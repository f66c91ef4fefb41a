"""Tables in a vendor's or a laboratory's own words, derived values, and contradictions."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from synth.errors import UserError
from synth.parts.catalogs import Catalogue, check_catalogue
from synth.parts.headers import NAMES, standard
from synth.parts.rows import FAMILIES, TorsionSpringRow

HEAD = "part,vendor,material,included_angle [deg],leg_convention,rate [N*m/rad],wire_diameter [mm],"


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.csv"
    path.write_text(text, encoding="utf-8")
    return path


def spring(path: Path, part: str) -> TorsionSpringRow:
    return Catalogue.load([path]).find_spring(part)


def test_a_vendors_table_in_inches_and_its_own_words(tmp_path: Path) -> None:
    """Torque at a deflection instead of a rate, outside diameter, hand as RH: all that the thesis' knee spring has."""
    path = written(
        tmp_path,
        "Part Number,Manufacturer,Material,Wind,Leg Angle (deg),Leg Type,Wire Dia. (in),O.D. (in),No. of Coils (1),"
        "Max. Torque (in-lb),Deflection (deg),Price (USD)\n"
        "VX-1,Vendor & Sons,music wire,RH,120,Tangential,0.135,1.16,7.17,20.62,60,9.99\n",
    )
    row = spring(path, "VX-1")
    assert row.complete, row.status
    assert row.vendor == "Vendor & Sons"
    assert (row.hand, row.leg_convention) == ("right", "tangent")
    assert row.price == "9.99 USD"
    assert row.wire_diameter == pytest.approx(3.429e-3)
    assert row.outer_diameter == pytest.approx(29.464e-3)
    assert row.rate == pytest.approx(20.62 * 0.112984829 / math.radians(60))
    assert row.rate_basis == "derived = max torque / max deflection"


def test_abbreviated_headings_of_a_workshops_own_sheet(tmp_path: Path) -> None:
    """Mfr was taken for a note, so that vendors: [Acme] found no spring."""
    path = written(
        tmp_path,
        "P/N,Mfr,Wire Dia. (in),O.D. (in),Num. of Coils,Leg Angle (deg),Spring Constant (in-lb/deg),Wire Material\n"
        "T-104,Acme,0.177,1.7,4.1667,120,1.18,Music Wire\n",
    )
    row = spring(path, "T-104")
    assert row.complete, row.status
    assert (row.vendor, row.material) == ("Acme", "music wire")
    assert row.rate == pytest.approx(1.18 * 0.112984829 * 180.0 / math.pi)


def test_a_vendors_damper_table(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "Model,Supplier,Damping Direction,Continuous,Torque (in-oz),Rated Speed (RPM)\nZ9,Maker,dual,yes,31,50\n",
    )
    row = Catalogue.load([path]).find_damper("z9")
    assert row.complete, row.status
    assert row.max_torque == pytest.approx(31 * 0.00706155, rel=1e-5)
    assert row.speed == pytest.approx(50 * math.pi / 30)
    assert row.direction == "both"


def test_a_maximum_speed_is_the_torques_if_none_other_is_stated(tmp_path: Path) -> None:
    head = "Model,Supplier,Damping Direction,Continuous,Torque (in-oz),"
    path = written(tmp_path, f"{head}Max Speed (RPM)\nZ9,Maker,dual,yes,31,50\n")
    row = Catalogue.load([path]).find_damper("z9")
    assert row.complete, row.status
    assert row.speed == row.max_speed == pytest.approx(50 * math.pi / 30)
    path = written(tmp_path, f"{head}Rated Speed (RPM),Maximum Speed (RPM)\nZ9,Maker,dual,yes,31,20,50\n")
    row = Catalogue.load([path]).find_damper("z9")
    assert (row.speed, row.max_speed) == pytest.approx((20 * math.pi / 30, 50 * math.pi / 30))


def test_own_words_never_take_the_place_of_the_catalogues(tmp_path: Path) -> None:
    """A table with both ``torque`` and ``max_torque`` keeps the second; every word stands for a column that exists."""
    path = written(
        tmp_path, "part,direction,continuous,torque [N*m],max_torque [N*m],speed [rpm]\nA,both,yes,9,0.2,50\n"
    )
    assert Catalogue.load([path]).find_damper("A").max_torque == pytest.approx(0.2)
    columns = {item.name for row in FAMILIES.values() for item in row.columns()}
    assert set(NAMES.values()) <= columns
    assert not set(NAMES) & columns - {"torque"}  # a curve's column, which its own family keeps
    assert standard("Torque", frozenset({"torque"})) == "torque"


def test_a_bad_cell_is_named_by_the_header_that_stands_in_the_file(tmp_path: Path) -> None:
    path = written(tmp_path, "Part No.,Spring Rate (N*m/rad),Wire Dia. (mm)\nA,1.5,two\n")
    (problem,) = check_catalogue([path])
    assert problem.key == "Wire Dia. (mm)"
    assert problem.line == 2
    assert '"two" is not a number' in problem.text


def test_the_outer_diameter_follows_from_the_inner(tmp_path: Path) -> None:
    path = written(tmp_path, HEAD + "inner_diameter [mm],body_coils [1]\nA,V,music wire,90,tangent,0.5,1.5,14,5.25\n")
    assert spring(path, "A").outer_diameter == pytest.approx(17e-3)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ("90,tangent,0.195,1.5,17,14,5.25,", None),
        ("90,tangent,0.195,1.5,17,13,5.25,", "twice the wire 1.5 mm make 16 mm, outer diameter 17 mm"),
        ("90,tangent,0.30,1.5,17,14,5.25,", "0.3 N*m/rad published, its geometry gives"),
        ("90,tangent,0.195,1.5,17,14,5.25,5", "body length 5 mm, but touching coils take 9.375 mm"),
        ("105,tangent,0.195,1.5,17,14,5.25,", "included angle 105 deg, but 5.25 coils with tangent legs give 90 deg"),
        ("105,,0.98,1.5,17,14,1.04,", "no leg_convention is given, so tangent is assumed; no other fits either"),
        ("14.4,,0.98,1.5,17,14,1.04,", "with radial or axial legs they agree: write leg_convention radial"),
        ("14.4,radial,0.98,1.5,17,14,1.04,", None),
    ],
)  # fmt: skip
def test_contradictory_rows_are_reported(tmp_path: Path, cells: str, message: str | None) -> None:
    """Rate within 25 % of the geometry's, OD = ID + 2 d, body length, angle against coils by a stated convention."""
    columns = "outer_diameter [mm],inner_diameter [mm],body_coils [1],body_length [mm]\n"
    path = written(tmp_path, HEAD + columns + f"A,V,music wire,{cells}\n")
    problems = check_catalogue([path])
    if message is None:
        assert problems == []
        assert spring(path, "A").complete
    else:
        (problem,) = problems
        assert message in problem.text
        assert (problem.key, problem.line) == ("A", 2)
        assert not spring(path, "A").complete


DAMPER = "part,vendor,direction,continuous,max_torque [N*m],speed [rpm],source,"


@pytest.mark.parametrize(
    ("columns", "cells", "message"),
    [
        ("max_speed [rpm]", "20", "torque at 50 rpm, above the maximum speed 20 rpm"),
        ("max_speed [rpm]", "50", None),
        ("bolts [1]", "4.5", "4.5 bolts: they are counted"),
        ("reverse_torque [N*m]", "0.4", "reverse torque 0.4 N*m above the torque 0.2 N*m"),
        ("min_temperature [degC],max_temperature [degC]", "60,-20", "least temperature 60 degC above the highest -20"),
        ("outer_diameter [in],shaft_size [mm]", "1.5,80", "shaft 80 mm not thinner than the body 38.1 mm"),
        (
            "bolt_circle [mm],bolt_diameter [mm],shaft_size [mm]",
            "30,3.4,27",
            "bolts on a circle of 30 mm meet the shaft",
        ),
        ("outer_diameter [mm],bolt_circle [mm],bolt_diameter [mm],shaft_size [mm]", "40,30,3.4,8", None),  # in its face
    ],
)
def test_contradictory_dampers_are_reported(tmp_path: Path, columns: str, cells: str, message: str | None) -> None:
    problems = check_catalogue([written(tmp_path, f"{DAMPER}{columns}\nD,V,both,yes,0.2,50,mine,{cells}\n")])
    assert [message is not None and message in problem.text for problem in problems] == [True] * (message is not None)


@pytest.mark.parametrize(("convention", "leg", "inside"), [("", 5, True), ("", 8, False), ("axial", 5, False)])
def test_a_leg_that_ends_in_its_coil_is_reported(tmp_path: Path, convention: str, leg: int, *, inside: bool) -> None:
    """A tangent leg of 6.9 mm ends at the outside of a coil of 29.4 mm of 3.4 mm wire."""
    columns = "part,vendor,material,rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],leg_length [mm],"
    row = f"S,V,music wire,2,3.4,29.4,{leg},{convention},mine"
    problems = check_catalogue([written(tmp_path, f"{columns}leg_convention,source\n{row}\n")])
    assert any("end inside the coil, whose outer radius is 14.7 mm" in problem.text for problem in problems) is inside


@pytest.mark.slow  # ``make scale`` measures it
def test_a_hundred_thousand_rows_are_read_and_checked(tmp_path: Path) -> None:
    """All of them; a torque-speed table of many parts is no quadratic matter."""
    rows, curves = 100_000, 20_000
    lines = [f"P{i},V,both,yes,{0.1 + i % 7},50\n" for i in range(rows)]
    path = written(tmp_path, "part,vendor,direction,continuous,max_torque [N*m],speed [rpm]\n" + "".join(lines))
    points = tmp_path / "points.csv"
    points.write_text("part,vendor,speed [rpm],torque [N*m]\n" + "".join(f"P{i},V,10,0.05\n" for i in range(curves)))
    catalogue = Catalogue.load([path, points])
    assert sum(row.complete for row in catalogue.dampers) >= rows
    assert catalogue.find_damper("P19999").curve_torque == (0.05,)
    assert catalogue.find_damper("P99999").curve_torque == ()


def test_a_duplicate_is_named_with_both_lines(tmp_path: Path) -> None:
    head = "part,vendor,direction,continuous,max_torque [N*m],speed [rpm]\n"
    path = written(tmp_path, head + "P77,V,both,yes,0.1,50\nP78,V,both,yes,0.2,50\np77,v,both,yes,0.2,50\n")
    with pytest.raises(UserError, match="v p77 is given twice in this file, first in line 2"):
        Catalogue.load([path])
