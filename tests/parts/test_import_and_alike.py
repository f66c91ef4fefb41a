"""A vendor's table as it comes, and substitutes for a part."""

from __future__ import annotations

import csv
from dataclasses import replace
from math import pi
from pathlib import Path

import pytest

from synth.cli import main
from synth.errors import UserError
from synth.parts.alike import find_substitutes
from synth.parts.catalog_import import import_table
from synth.parts.catalogs import Catalogue

TABLE = (
    "ITEM NUMBER,Maker,Wire,O.D. (in),BODY COILS,Leg Angle (deg),Material,Wind,Torque (in-lb),Deflection (deg),Hue\n"
    "A1,Acme,0.08 in,0.75,6.17,120,Music Wire,RH,6.57,90,red\n"
    "A2,Acme,2 mm,0.75,6.17,120,MUSIC WIRE,LH,6.1,90,red\n"
    "B1,Beta Springs,0.05 in,0.5,4.25,90,music wire,RH,2.3,90,blue\n"
)


def test_a_table_becomes_a_file_a_vendor_in_any_case_and_unit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text(TABLE)
    assert main(["-q", "catalog", "import", "table.csv", "--map", "Hue=note", "--out", "mine"]) == 0
    assert sorted(path.name for path in Path("mine").glob("*.csv")) == ["acme.csv", "beta_springs.csv"]
    with Path("mine/acme.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["wire_diameter [mm]"]) for row in rows] == [2.032, 2.0]
    assert {row["material"] for row in rows} == {"music wire"}
    assert [row["hand"] for row in rows] == ["right", "left"]
    assert float(rows[0]["max_torque [N*m]"]) == pytest.approx(6.57 * 0.1129848290)
    springs = Catalogue.load([Path("mine/acme.csv"), Path("mine/beta_springs.csv")])
    assert springs.find_spring("A1").complete
    assert springs.find_spring("A1").rate == pytest.approx(6.57 * 0.1129848290 / 1.5707963)


@pytest.mark.parametrize("coils", ["Body Coils", "BODY COILS (turns)", "body_coils [1]", "No. of coils"])
def test_a_table_of_one_s_own_may_use_a_vendor_s_words(coils: str, tmp_path: Path) -> None:
    """A number of coils needs no unit; materials are known in any case."""
    path = tmp_path / "mine.csv"
    path.write_text(
        f"Part Number,Vendor,Material,Wind,Leg Angle (deg),Spring Rate (in-lb/deg),Wire Dia. (in),O.D. (in),{coils}\n"
        "X1,Acme,Music Wire,RH,120,0.34,0.135,1.16,7.17\n"
    )
    row = Catalogue.load([path]).find_spring("X1")
    assert (row.material, row.body_coils, row.complete) == ("music wire", 7.17, True)


def test_a_damper_s_shaft_and_screws_are_columns(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(
        "Part Number,Torque (N*m),Max Speed (RPM),Damping Direction,continuous,Body Diameter (mm),Body Length (mm),"
        "Bolt Circle Diameter (mm),Number of bolts,Hole Diameter (mm),Shaft Type,Shaft Shape,Shaft Diameter (mm)\n"
        "D1,0.5,50,dual,yes,42,18,52,3,3.4,hollow,Square,6\n"
    )
    row = Catalogue.load([path]).find_damper("D1")
    assert row.complete
    assert (row.shaft_side, row.shaft_form, row.bolts) == ("bore", "square", 3.0)
    assert [row.outer_diameter, row.body_length, row.bolt_circle, row.bolt_diameter, row.shaft_size] == pytest.approx(
        [0.042, 0.018, 0.052, 0.0034, 0.006]
    )


def imported(tmp_path: Path, rows: str, mapping: dict[str, str] | None = None, titles: str = "") -> dict[str, str]:
    """The first row of a spring table of the vendor V that has two more columns, by our headers."""
    path = tmp_path / "table.csv"
    path.write_text(f"Part Number,Wire Dia. (in),O.D. (in),{titles or 'Tolerance,Price'}\n{rows}", encoding="utf-8")
    table = import_table(path, mapping or {}, "V")
    return dict(zip(table.header, table.rows["v.csv"][0], strict=True))


def test_a_percentage_has_a_unit(tmp_path: Path) -> None:
    """A tolerance of 10 without one was read as 1000 %."""
    said = 'table.csv:2: Tolerance: "10" has no unit: write it into each cell, such as 10 %, or --map "Tolerance=rate_'
    with pytest.raises(UserError) as caught:
        imported(tmp_path, "A1,0.08,0.75,10,\n")
    assert said in str(caught.value)
    with pytest.raises(UserError, match="has no unit"):
        imported(tmp_path, "A1,0.08,0.75,10,\n", {"Tolerance": "rate_tolerance"})
    assert imported(tmp_path, "A1,0.08,0.75,10 %,\n")["rate_tolerance [%]"] == "10"
    assert imported(tmp_path, "A1,0.08,0.75,10,\n", {"Tolerance": "rate_tolerance [%]"})["rate_tolerance [%]"] == "10"
    assert imported(tmp_path, "A1,0.08,0.75,10,6\n", titles="Tolerance (%),Coils")["rate_tolerance [%]"] == "10"


def test_an_imported_price_has_its_currency(tmp_path: Path) -> None:
    """A currency in the header is no unit of length, and is not lost."""
    assert imported(tmp_path, "A1,0.08,0.75,6,12.5\n", titles="Coils,Price (EUR)")["price"] == "12.5 EUR"
    assert imported(tmp_path, "A1,0.08,0.75,,$12.5\n", {"Price": "price [usd]"})["price"] == "12.5 USD"
    with pytest.raises(UserError, match=r"table.csv:2: Price \(EUR\): .12.5 USD. is in USD, its column in EUR"):
        imported(tmp_path, "A1,0.08,0.75,6,12.5 USD\n", titles="Coils,Price (EUR)")


def test_every_bad_cell_of_a_vendor_s_table_is_named_in_its_own_words(tmp_path: Path) -> None:
    with pytest.raises(UserError) as caught:
        imported(tmp_path, 'A1,-1,nan,,\nA2,2 mm,"0,8",,\n,1,1,,\nA3,5/64,N/A,,\na3,1,2,,\nA3,1,2,,\n')
    assert [(problem.line, problem.key) for problem in caught.value.problems] == [
        (2, "Wire Dia. (in)"),
        (2, "O.D. (in)"),
        (3, "Wire Dia. (in)"),
        (3, "O.D. (in)"),
        (4, "Part Number"),
        (5, "O.D. (in)"),
        (7, "Part Number"),
    ]
    text = str(caught.value)
    for said in ('"-1" must be above 0', "leave the cell empty if it is not known", "decimals take a point"):
        assert said in text
    assert "its column is in [in]; leave the unit out of the cell" in text
    assert "V A3 is given twice in this table, first in line 6" in text
    assert imported(tmp_path, "A1,5/64,0.75,,\n")["wire_diameter [mm]"] == "1.984375"


@pytest.mark.parametrize("row", ["A2,0,08,0.75,10 %,", "A2,0.08,0.75", "A2,0.08,0.75,10 %,,6"])
def test_a_row_of_another_length_than_the_header_is_refused(row: str, tmp_path: Path) -> None:
    """An unquoted decimal comma shifts all cells after it."""
    said = rf"table.csv:3: has {row.count(',') + 1} cells where the header has 5; decimals take a point"
    with pytest.raises(UserError, match=said):
        imported(tmp_path, f"A1,0.08,0.75,10 %,\n{row}\n")


def test_a_mapping_comes_before_what_a_header_is_known_as(tmp_path: Path) -> None:
    titles = "Coils,Measured wire"
    row = imported(tmp_path, "A1,0.08,0.75,6,0.075\n", {"Measured wire": "wire_diameter [in]"}, titles)
    assert float(row["wire_diameter [mm]"]) == pytest.approx(1.905)
    with pytest.raises(
        UserError, match=r'--map: "Measured wire=wire_dia \[in\]": torsion springs have no column wire_d'
    ):
        imported(tmp_path, "A1,0.08,0.75,6,0.075\n", {"Measured wire": "wire_dia [in]"}, titles)
    both = {"Measured wire": "wire_diameter [in]", "Wire Dia. (in)": "wire_diameter [in]"}
    with pytest.raises(UserError, match=r"--map: Wire Dia. \(in\) and Measured wire are both mapped to wire_diameter"):
        imported(tmp_path, "A1,0.08,0.75,6,0.075\n", both, titles)


@pytest.mark.parametrize("stated", ["rate", "rate [N*mm/deg]", "rate [mN*m/deg]"])
@pytest.mark.parametrize("title", ["Federrate [N*mm/deg]", "Federrate (Nmm/deg)"])
def test_a_mapped_column_has_the_unit_of_its_header(title: str, stated: str, tmp_path: Path) -> None:
    """12.5 N*mm/deg; the message proposed N*m/rad, which made it 17 times stiffer."""
    path = tmp_path / "table.csv"
    path.write_text(f"Part;{title};Durchmesser (außen);OD [mm]\nA1;12,5;fein;14,2\n")
    table = import_table(path, {title: stated, "Durchmesser (außen)": "note"}, "V")
    assert float(table.columns("v.csv")["rate [N*m/rad]"][0] or 0.0) == pytest.approx(12.5e-3 * 180.0 / pi)
    with pytest.raises(UserError, match=r"the header says N\*mm/deg; leave the unit out, .*=rate\"$"):
        import_table(path, {title: "rate [N*m/rad]"}, "V")


def test_vendors_whose_names_give_one_file_share_it(tmp_path: Path) -> None:
    """The second one's rows took the place of the first one's."""
    path = tmp_path / "table.csv"
    path.write_text("Part,Vendor,Torque (in-oz),Speed (RPM)\nD1,Lee Spring,31,50\n\nD2,LEE SPRING,3,5\n")
    table = import_table(path, {})
    assert [row[0] for row in table.rows["lee_spring.csv"]] == ["D1", "D2"]
    assert table.lines == {"lee_spring.csv": (2, 4)}


def test_a_temperature_below_0_stays_a_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text(
        "Part,Torque (in-oz),Speed (RPM),temperature (degC),min_temperature\nD1,31,50,-5,-9 °C\n"
    )
    assert main(["-q", "catalog", "import", "table.csv", "--vendor", "V", "--out", "mine"]) == 0
    row = Catalogue.load([Path("mine/v.csv")]).find_damper("D1")
    assert (row.temperature, row.min_temperature) == (-5.0, -9.0)


@pytest.mark.parametrize(
    ("mapping", "table", "said"),
    [
        ({"Foo": "note"}, TABLE, "no column is called Foo"),
        ({}, TABLE.replace("2 mm", "2"), "Wire:"),
        ({}, TABLE.replace("Maker", "Colour"), "--vendor NAME"),
        ({}, "a,b\n1,2\n", "is not a table of torsion springs or dampers"),
    ],
)
def test_unreadable_tables_are_reported(mapping: dict[str, str], table: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text(table)
    with pytest.raises(UserError, match=said):
        import_table(path, mapping)


def test_substitutes_are_ranked_with_their_differences() -> None:
    catalogue = Catalogue.load()
    found = find_substitutes(catalogue, catalogue.find_spring("LTR080F 10 S"))
    assert [item.distance for item in found] == sorted(item.distance for item in found)
    assert all(item.row.choosable for item in found)
    assert found[0].row.part == "9271K621"
    assert "rate -20%" in found[0].differs
    spelled = replace(catalogue.find_spring("LTR080F 10 S"), material="Stainless 302 (ASTM A313)")
    assert not [each for item in find_substitutes(catalogue, spelled) for each in item.differs if "tainless" in each]
    dampers = find_substitutes(catalogue, catalogue.find_damper("6597K8"), most=40)
    nearest = next(item for item in dampers if item.row.part == "6597K19")
    # Same family, same law: the torque at any speed is that of the vendor's points, 31 and 7 in-oz.
    assert nearest.differs == (f"torque {31 / 7 - 1:+.0%}",)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_of_semicolons_or_tabs_with_decimal_commas_is_read(
    separator: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was said to be no table of springs or dampers."""
    monkeypatch.chdir(tmp_path)
    lines = (
        "Part Number|Wire Dia.|O.D. (mm)|Leg Angle (deg)|Spring Rate (N*m/rad)|Coils|Material|Price",
        "3,5|0,08 in|19,05|120|0,48|6,1667|Music Wire|12,50 EUR",
    )
    Path("table.csv").write_text("\n".join(line.replace("|", separator) for line in lines) + "\n")
    found = import_table(Path("table.csv"), {}, "Acme")
    ((row,),) = found.rows.values()
    cells = dict(zip(found.header, row, strict=True))
    assert cells["part"] == "3,5"
    assert [float(cells[name]) for name in ("wire_diameter [mm]", "outer_diameter [mm]", "body_coils [1]")] == [
        pytest.approx(2.032),
        19.05,
        6.1667,
    ]
    assert cells["price"] == "12.50 EUR"
