"""Every row of the built-in catalogues: readable, traceable, positive, and agreeing with itself or flagged."""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from synth.cli import main
from synth.errors import UserError
from synth.parts.catalog_table import read_table
from synth.parts.catalogs import Catalogue, catalog_folder, catalogue_rows_as_table, check_catalogue
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.coil_angle import angle_mismatch
from synth.parts.row_check import contradictions, geometric_rates, missing_values
from synth.parts.rows import FAMILIES, GearMotorRow, TorsionSpringRow
from synth.parts.usable import offers
from synth.units import factor

CATALOGUE = Catalogue.load()
ALL_ROWS = [row for family in FAMILIES for row in CATALOGUE.rows(family)]
SPRINGS_WITH_GEOMETRY = [row for row in CATALOGUE.springs if geometric_rates(row, CATALOGUE.known_materials)]


def _name(row: CatalogueRow) -> str:
    return row.place.removeprefix("catalogs/")


@pytest.mark.parametrize("family", FAMILIES)
def test_every_line_of_the_file_is_a_row(family: str) -> None:
    with (catalog_folder() / f"{family}.csv").open(encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == len(CATALOGUE.rows(family)) > 0
    assert all(value is not None for line in lines for value in line.values())
    for title in lines[0]:
        unit = re.search(r"\[(.*)\]", title)
        item = next(each for each in FAMILIES[family].columns() if each.name == title.split("[")[0].strip())
        assert (unit is None) == (item.metadata["unit"] is None), title


@pytest.mark.parametrize("row", ALL_ROWS, ids=_name)
def test_every_row_is_traceable_and_its_numbers_allowed(row: CatalogueRow) -> None:
    assert row.source
    assert not re.search(r"seed|text search|\.txt|corpus", row.source + row.note)
    assert row.status == "complete" or re.match(
        r"(usable|incomplete|contradiction|size only|alternate|suspect): ?\S?", row.status
    )
    for item in row.columns():
        value = getattr(row, item.name)
        if isinstance(value, float):
            assert math.isfinite(value)
            assert value > 0.0 or item.metadata["zero"] or item.metadata["signed"], item.name
        else:
            assert value is None or isinstance(value, str)


@pytest.mark.parametrize("row", ALL_ROWS, ids=_name)
def test_complete_rows_lack_nothing_and_contradict_nothing(row: CatalogueRow) -> None:
    lacking, wrong = missing_values(row, CATALOGUE.known_materials), contradictions(row, CATALOGUE.known_materials)
    if row.complete:
        assert not lacking
        assert not wrong
    if wrong:
        assert row.status.startswith("contradiction: ")
        assert row.state == "contradiction"


def test_the_column_says_the_state_and_what_follows_from_it_does_not_read_the_column() -> None:
    for row in ALL_ROWS:
        assert row.state not in ("", "other"), row.place
        assert row.status.startswith(row.state)
        other = replace(row, status="usable contradiction complete")
        assert (other.complete, other.choosable, other.sound) == (row.complete, row.choosable, row.sound)
        assert not row.reasons or row.judged(row.state, row.reasons) == row


@pytest.mark.parametrize(
    ("status", "state", "choosable"),
    [("", "", False), ("complete", "complete", True), ("usable: measured", "usable", True),
     ("complete set of two", "other", False), ("discontinued", "other", False), ("size only: no strength", "size only",
     False)],
)  # fmt: skip
def test_a_table_s_status_is_read_once(tmp_path: Path, status: str, state: str, choosable: bool) -> None:
    table = tmp_path / "springs.csv"
    table.write_text(f"part,rate [N*m/rad],status\nA,1,{status}\n")
    (row,) = read_table(table).rows
    assert (row.state, row.status, row.choosable) == (state, status, choosable)


def test_a_gear_motor_s_shaft_and_basis_are_read_from_their_columns() -> None:
    """The shaft was searched for in the words of its size."""
    motors = [row for row in ALL_ROWS if isinstance(row, GearMotorRow)]
    assert {row.shaft_size for row in motors} == {3e-3, 4e-3, None}
    assert sum(row.interpolated for row in motors) == 3
    assert not replace(motors[0], basis="derived in part").interpolated


@pytest.mark.parametrize("row", SPRINGS_WITH_GEOMETRY, ids=lambda row: row.part)
def test_rate_agrees_with_the_geometry_or_is_flagged(row: TorsionSpringRow) -> None:
    """E d^4 / (64 D N) and / (10.8 D N) per turn, reckoned here from the CSV's own numbers."""
    assert row.rate
    assert row.wire_diameter
    assert row.outer_diameter
    assert row.body_coils
    modulus = CATALOGUE.known_materials.modulus(row.material, row.wire_diameter)
    assert modulus
    bending = modulus * row.wire_diameter**4 / (64 * (row.outer_diameter - row.wire_diameter) * row.body_coils)
    near = min(abs(bending / row.rate - 1), abs(bending * 64 / (10.8 * math.tau) / row.rate - 1))
    assert (near > 0.25) == row.status.startswith("contradiction: 0.198"), near


def test_the_one_contradictory_rate_is_listed_but_not_complete() -> None:
    suspect = CATALOGUE.find_spring("9271K272")
    assert not suspect.complete
    assert "0.449" in suspect.status


@pytest.mark.parametrize("row", [row for row in CATALOGUE.springs if row.leg_convention], ids=lambda row: row.part)
def test_included_angle_agrees_with_coils(row: TorsionSpringRow) -> None:
    assert row.body_coils
    assert row.included_angle is not None
    assert abs(angle_mismatch(row.body_coils, row.included_angle, "tangent")) < math.radians(4)


def test_as_published_figures_are_the_converted_ones() -> None:
    """Inch sizes in `as_published` of the strength tables, converted again."""
    checked = 0
    for row in CATALOGUE.wires:
        if not row.nominal_size or not row.diameter:
            continue
        printed = re.search(r"(\d*\.\d+) in", row.as_published)
        assert printed
        assert row.diameter == pytest.approx(float(printed[1]) * 0.0254, rel=1e-6)
        ksi = re.search(r"(\d{3})[-/](\d{3})", row.as_published)
        if ksi and row.min_tensile_strength:
            assert row.min_tensile_strength == pytest.approx(float(ksi[1]) * 6.894757e6, rel=1e-5)
            checked += 1
    assert checked == 106


def test_dampers_of_the_thesis_in_published_units() -> None:
    for part, ounces in (("6597K21", 312), ("6597K19", 31), ("6597K8", 7)):
        row = CATALOGUE.find_damper(part)
        assert row.complete
        assert row.max_torque == pytest.approx(ounces * factor("ozf*in", "N*m"), rel=1e-5)
        assert row.speed == pytest.approx(50 * math.tau / 60)
        assert row.secant_rate == pytest.approx(ounces * factor("ozf*in", "N*m") / (50 * math.tau / 60), rel=1e-5)
        assert row.direction == "both"
        assert row.allows_travel(math.tau)


def test_columns_that_are_not_vendors_data_are_left_out() -> None:
    assert not [row for row in CATALOGUE.springs if "lab" in row.vendor]
    header = (catalog_folder() / "dampers.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "identified" not in header


def test_thesis_springs_can_be_chosen() -> None:
    knee = CATALOGUE.find_spring("ltr135h 10 m")
    assert knee.complete
    assert knee.rate == 2.224743
    assert knee.mean_diameter == pytest.approx(26.035e-3)
    assert knee.close_wound_length == pytest.approx(knee.body_length, rel=0.01)
    assert CATALOGUE.find_spring("LTR080F 10 S").complete


class TestWire:
    """Strength by the table, not by the law that is too high for thick wire."""

    def test_table_before_law(self) -> None:
        music = CATALOGUE.find_material("A228")
        listed = music.tensile_strength(4.8768e-3)
        assert listed is not None
        assert (listed.basis, listed.value) == ("table", pytest.approx(241 * 6.894757e6, rel=1e-5))
        law = next(row for row in music.records if row.record == "strength power law").strength(4.8768e-3)
        assert law is not None
        assert law / listed.value == pytest.approx(1.057, abs=5e-4)

    def test_between_two_sizes(self) -> None:
        music = CATALOGUE.find_material("music")
        low, mid, high = (music.tensile_strength(d * 1e-3) for d in (4.4958, 4.7625, 4.8768))
        assert low is not None
        assert mid is not None
        assert high is not None
        assert mid.basis == "interpolated"
        assert high.value < mid.value < low.value

    def test_law_is_flagged(self) -> None:
        silicon = CATALOGUE.find_material("chrome silicon").tensile_strength(4e-3)
        assert silicon is not None
        assert silicon.basis == "law"
        assert CATALOGUE.find_material("music wire").tensile_strength(20e-3) is None

    @pytest.mark.parametrize(
        ("millimetres", "gigapascal"),
        [(0.5, 203.4), (0.8128, 203.4), (1.0, 200.0), (2.0, 196.5), (3.175, 196.5), (5.0, 193.0)],
    )
    def test_modulus_of_music_wire(self, millimetres: float, gigapascal: float) -> None:
        assert CATALOGUE.known_materials.modulus("music wire", millimetres * 1e-3) == pytest.approx(gigapascal * 1e9)

    def test_stock_is_sorted_and_inside_the_table(self) -> None:
        sizes = [row.diameter or 0.0 for row in CATALOGUE.find_material("music wire").stock()]
        assert sizes == sorted(sizes)
        assert sizes[0] == pytest.approx(0.1016e-3)
        assert sizes[-1] == pytest.approx(6.35e-3)
        metric = [row.diameter for row in CATALOGUE.find_material("music wire").stock("metric")]
        assert 5e-3 in [pytest.approx(size) for size in metric]

    def test_suspect_modulus_is_not_used(self) -> None:
        assert CATALOGUE.known_materials.modulus("stainless 17-7", 2e-3) == pytest.approx(203.395e9)


def test_near_misses_are_named() -> None:
    with pytest.raises(UserError, match="did you mean LTR135H 10 M"):
        CATALOGUE.find_spring("LTR135H 10M")
    with pytest.raises(UserError, match="6597K21"):
        CATALOGUE.find_damper("6597K22")
    with pytest.raises(UserError, match="music wire"):
        CATALOGUE.find_material("musik wire")
    with pytest.raises(UserError, match="did you mean dampers"):
        catalogue_rows_as_table("damper")


@pytest.mark.parametrize("family", FAMILIES)
def test_table_for_the_screen(family: str) -> None:
    table = catalogue_rows_as_table(family, CATALOGUE)
    assert len(table.rows) == len(CATALOGUE.rows(family))
    assert {len(row) for row in table.rows} == {len(table.header)}
    assert table.header[-1] == "source"


def test_table_shows_the_files_numbers() -> None:
    table = catalogue_rows_as_table("dampers", CATALOGUE)
    row = next(row for row in table.rows if row[0] == "6597K21")
    assert row[table.header.index("speed [rpm]")] == "50"
    assert row[table.header.index("max_torque [N*m]")] == "2.2032"


def test_built_in_check_names_the_flagged_rows_only() -> None:
    motors = {f"N20 {variant} 6V {ratio}:1" for variant in ("LP", "MP") for ratio in (5, 10)}
    assert {problem.key for problem in check_catalogue()} == {"9271K272"} | motors


def test_folder_holds_what_the_wheel_ships() -> None:
    folder: Path = catalog_folder()
    # Fasteners are dimensions for the drawing and no parts to choose: ``cad.hardware`` reads them.
    fasteners = {
        "machine_screws", "socket_screws", "plain_washers", "heat_set_inserts", "hexagon_nuts",
        "ball_bearings", "shaft_collars", "shim_rings", "dowel_pins",
    }  # fmt: skip
    assert {path.stem for path in folder.glob("*.csv")} == set(FAMILIES) | fasteners


def test_enough_parts_can_be_chosen_and_unpublished_values_are_named() -> None:
    """40 springs are not there to be had: of 51 others the rate or the wire is not known, and nothing is made up."""
    springs = [row for row in CATALOGUE.springs if row.choosable]
    dampers = [row for row in CATALOGUE.dampers if row.choosable]
    assert len(springs) >= 34
    assert len(dampers) >= 25
    for row in (*springs, *dampers):
        assert row.complete == (not row.derived)
        if row.complete:  # a joint is printed for one hand
            assert row.measure in ((), ("hand",))
            continue
        assert all(text in row.status for text in (*row.derived, *row.measure))


def test_an_assumed_speed_widens_the_torque_by_its_whole_range() -> None:
    """From 5 to 50 rpm about 15.8: sqrt(10)^0.47 - 1 = 0.718, with 0.15 of the torque itself 0.733."""
    row = CATALOGUE.find_damper("D40B0-R503")
    assert row.torque_tolerance == pytest.approx(math.hypot(0.15, math.sqrt(10.0) ** 0.47 - 1.0))
    complete = CATALOGUE.find_damper("6597K21")
    assert complete.torque_tolerance is None
    assert offers(complete) == (complete,)


def test_a_range_of_torques_is_offered_from_end_to_end() -> None:
    row = CATALOGUE.find_damper("TD73")
    torques = [offer.max_torque or 0.0 for offer in offers(row)]
    assert torques[0] == pytest.approx(0.05)
    assert torques[-1] == pytest.approx(0.29)
    assert max(b / a for a, b in pairwise(torques)) <= 1.3 + 1e-9
    assert offers(row)[1].order.startswith("TD73 at 0.0")


def test_an_angle_that_is_not_published_is_open_until_it_is_measured() -> None:
    row = CATALOGUE.find_spring("T10100")
    assert row.included_angle == pytest.approx(math.radians(90.0))
    assert row.free_angle_tolerance == pytest.approx(math.pi)
    assert "included angle" in row.measure
    counted = CATALOGUE.find_spring("BC001")
    assert counted.body_coils == pytest.approx(3.0 + 1.0 / 6.0)
    assert counted.assumed == ("body_coils",)
    assert (counted.state, row.assumed) == ("usable", ("included_angle", "free_angle_tolerance"))


def test_an_assumed_value_is_shown_as_such(capsys: pytest.CaptureFixture[str]) -> None:
    """The coils of BC001, 3 in the table, stood as 3.16667 among its published values."""
    assert main(["catalog", "show", "BC001"]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    assert [value for name, value in lines if name == "body_coils"] == ["3.16667 (not published, see status)"]
    assert [value for name, value in lines if name == "included_angle"] == ["120 deg"]
    assert main(["catalog", "show", "BC001", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"][0]["assumed"] == ["body_coils"]


def test_as_many_springs_and_dampers_can_be_chosen_as_the_readme_says() -> None:
    assert sum(row.choosable for row in CATALOGUE.springs) == 34
    assert sum(row.choosable for row in CATALOGUE.dampers) >= 25
    named = {
        r.part for r in CATALOGUE.springs if not r.choosable and r.rate is not None and r.included_angle is not None
    }
    assert named == {"9271K272", "9271K665", "9271K97", "T030-180-250"}
    stated = (catalog_folder() / "README.md").read_text(encoding="utf-8")
    assert "34 of the 90 rows can be chosen" in stated
    assert all(part in stated for part in named)


def test_the_length_at_the_largest_torque_does_not_give_the_coils() -> None:
    """Close-wound coils would take wire * (coils + 1 + turns); the vendor's rows do not."""
    ratios = []
    for row in CATALOGUE.springs:
        length, wire, coils, turned = (
            row.body_length_at_max_torque,
            row.wire_diameter,
            row.body_coils,
            row.max_deflection,
        )
        if row.vendor == "McMaster-Carr" and None not in (length, wire, coils, turned):
            ratios.append(length / (wire * (coils + 1.0 + turned / (2.0 * math.pi))))
    assert len(ratios) == 8
    assert min(ratios) == pytest.approx(0.85, abs=0.01)
    assert max(ratios) == pytest.approx(1.18, abs=0.01)
