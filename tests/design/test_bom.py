"""The list of parts: every drawn part, its mass, and no cell that a spreadsheet would evaluate."""

from __future__ import annotations

import csv
from types import SimpleNamespace

import pytest

from synth.design import bom
from synth.design.bom import write_bom
from synth.files.text_forms import defused


@pytest.mark.parametrize("cell", ["=cmd|' /C calc'!A0", "+1", "-2", "@SUM(A1)", "\t=1", "  =1", "|x", "%x", "\n=1"])
def test_spreadsheet_formulas_are_escaped(cell: str) -> None:
    assert defused(cell) == f"'{cell}"


@pytest.mark.parametrize("cell", ["6597K21", "", "music wire", "1"])
def test_plain_text_is_not_escaped(cell: str) -> None:
    assert defused(cell) == cell


SCREW = "buy: ISO 7380-1 - M3 x 10, steel"


def part(name: str, family: str, mass: float | None, made: str = "print") -> dict[str, object]:
    size, weight = [30.0, 4.0, 4.0], None if mass is None else {"value": mass, "unit": "g"}
    return {"part": f"hip_{name}", "joint": "hip", "family": family, "made": made, "material": "", "mass": weight,
            "in_link": {"size": size}}  # fmt: skip


def test_equal_lines_are_merged_with_quantity_and_mass(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    bought = [
        {"joint": "hip", "item": "torsion spring, 2 N*m/rad", "vendor": "=cmd|'/C calc'!A0", "part": "-LTR",
         "quantity": "2", "source": "a sheet"},
        {"joint": "hip", "item": "rotary damper", "vendor": "V", "part": "D", "quantity": "1", "source": ""},
    ]  # fmt: skip
    monkeypatch.setattr(bom, "bought_or_wound", lambda design: bought)
    design = SimpleNamespace(
        built=SimpleNamespace(joint_names=("hip",), joints=(SimpleNamespace(name="hip"),)),
        project=SimpleNamespace(cad=SimpleNamespace(mount=True)),
    )
    parts = [
        part("upper_screw_1", "screw", 1.0, SCREW), part("upper_screw_2", "screw", 1.0, SCREW),
        part("upper", "upper", 40.0), part("spring", "spring", 3.0), part("damper", "damper", None),
    ]  # fmt: skip
    write_bom(design, parts, tmp_path / "bom.csv")  # type: ignore[arg-type]
    with (tmp_path / "bom.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    found = {row["item"]: row for row in rows}
    spring = found["torsion spring, 2 N*m/rad"]
    assert (spring["vendor"], spring["part"]) == ("'=cmd|'/C calc'!A0", "'-LTR")
    assert (spring["quantity"], spring["mass [g]"]) == ("2", "6.00")
    screw = found["ISO 7380-1 - M3 x 10, steel"]
    assert (screw["quantity"], screw["mass [g]"], screw["vendor"]) == ("2", "2.00", "any")
    assert next(row for row in rows if row["item"].startswith("heat-set insert M3"))["quantity"] == "2"
    assert found["rotary damper"]["mass [g]"] == ""
    assert (screw["standard"], screw["size"], screw["length [mm]"]) == ("ISO 7380-1", "M3", "10")
    mount = next(row for row in rows if row["item"].startswith("M4 screw for the mount"))
    assert (mount["quantity"], mount["vendor"]) == ("4", "any")
    assert sum(row["item"].startswith("torsion spring") for row in rows) == 1  # not again as a drawn part


def test_a_spring_pair_orders_one_of_each_hand(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    line = {
        "joint": "hip",
        "item": "torsion spring, 2 N*m/rad",
        "vendor": "V",
        "part": "L",
        "quantity": "2",
        "source": "",
    }
    monkeypatch.setattr(bom, "bought_or_wound", lambda design: [line])
    design = SimpleNamespace(
        built=SimpleNamespace(joint_names=("hip",), joints=(SimpleNamespace(name="hip"),)),
        project=SimpleNamespace(cad=SimpleNamespace(mount=True)),
    )
    drawn = [part("spring", "spring", 3.0, "buy or wind"), part("spring_2", "spring", 3.0, "buy or wind")]
    for parts, item in ((drawn, f"{line['item']}, one of each hand"), (drawn[:1], line["item"])):
        write_bom(design, parts, tmp_path / "bom.csv")  # type: ignore[arg-type]
        with (tmp_path / "bom.csv").open(newline="") as stream:
            rows = [row for row in csv.DictReader(stream) if row["item"].startswith("torsion")]
        assert [(row["item"], row["quantity"], row["mass [g]"]) for row in rows] == [(item, "2", "6.00")]


def test_every_line_has_its_ordering_data(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    wire = {"joint": "hip", "item": "music wire, 2 mm, 540 mm a spring: wind 6 coils", "vendor": "to wind", "part": "",
            "quantity": "1", "source": "a sheet"}  # fmt: skip
    monkeypatch.setattr(bom, "bought_or_wound", lambda design: [wire])
    design = SimpleNamespace(
        built=SimpleNamespace(joint_names=("hip",), joints=(SimpleNamespace(name="hip"),)),
        project=SimpleNamespace(cad=SimpleNamespace(mount=False)),
    )
    drawn = {
        "bearing_a": ("bearing", "buy: ISO 15 - 628/8-2Z ball bearing, 8 x 16 x 5 mm, two shields (sold as 688ZZ)"),
        "pin": ("pin", "buy: ISO 8734 - 2.5 x 24 dowel pin, steel"),
        "collar_a": ("collar", "buy: DIN 705 A - 8 shaft collar, steel, with set screw M4"),
        "thrust_washer_a": ("washer", "buy: DIN 988 - 8 x 14 x 0.5 shim ring, steel"),
        "upper_socket_screw": ("screw", "buy: ISO 4762 - M3 x 30, steel; with nut"),
        "seat_screw_1": ("screw", "buy: ISO 7380-1 - M3 x 12, steel, with washer ISO 7089 - 3"),
        "shaft": ("shaft", "cut from ground rod, h6, 8 mm, 76.2 mm long; drilled for its pins"),
    }
    parts = [part(name, family, 1.0, made) for name, (family, made) in drawn.items()]
    printed = {**part("upper", "upper", 46.2), "volume": {"value": 38.5e3, "unit": "mm^3"}}
    write_bom(design, [*parts, printed], tmp_path / "bom.csv")  # type: ignore[arg-type]
    with (tmp_path / "bom.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    found = {(row["standard"], row["size"], row["length [mm]"], row["how"]) for row in rows}
    assert {
        ("ISO 15", "628/8-2Z", "", "buy"), ("ISO 8734", "2.5", "24", "buy"), ("DIN 705 A", "8", "", "buy"),
        ("DIN 988", "8 x 14 x 0.5", "", "buy"), ("ISO 4762", "M3", "30", "buy"), ("ISO 7380-1", "M3", "12", "buy"),
        ("ISO 7089", "3", "", "buy"), ("", "8", "79.2", "cut"), ("", "2 mm", "600", "wind"),
    } <= found  # fmt: skip
    inserts = [row for row in rows if row["item"].startswith("heat-set insert")]
    assert [(row["size"], row["quantity"]) for row in inserts] == [("M3", "1")]  # the screw with a nut needs none
    assert {row["vendor"] for row in rows} <= {"any", "", "ruthex"}
    assert not any("ruthex" in row["item"] for row in rows)  # a vendor stands in the vendor's column only
    time = next(row for row in rows if row["how"] == "print")
    assert float(time["print time [h]"]) == pytest.approx(3 + 4 / 60, abs=0.05)
