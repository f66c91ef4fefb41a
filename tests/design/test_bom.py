"""The list of parts: everything that is drawn, with masses, and no cell that a spreadsheet would run."""

from __future__ import annotations

import csv
from types import SimpleNamespace

import pytest

from synth.design import bom
from synth.design.bom import write_bom
from synth.files.text_forms import defused


@pytest.mark.parametrize("cell", ["=cmd|' /C calc'!A0", "+1", "-2", "@SUM(A1)", "\t=1", "  =1", "|x", "%x", "\n=1"])
def test_what_a_spreadsheet_would_run_is_defused(cell: str) -> None:
    assert defused(cell) == f"'{cell}"


@pytest.mark.parametrize("cell", ["6597K21", "", "music wire", "1"])
def test_what_it_would_not_is_left_alone(cell: str) -> None:
    assert defused(cell) == cell


SCREW = "buy: ISO 7380-1 - M3 x 10, steel"


def part(name: str, family: str, mass: float | None, made: str = "print") -> dict[str, object]:
    size, weight = [30.0, 4.0, 4.0], None if mass is None else {"value": mass, "unit": "g"}
    return {"part": f"hip_{name}", "joint": "hip", "family": family, "made": made, "material": "", "mass": weight,
            "size": size}  # fmt: skip


def test_lines_are_merged_with_their_number_and_mass(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
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
    assert found["M4 screw for the mount"]["quantity"] == "4"
    assert sum(row["item"].startswith("torsion spring") for row in rows) == 1  # not again as a drawn part


def test_of_a_drawn_pair_one_of_each_hand_is_ordered(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
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
