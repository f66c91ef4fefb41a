"""The list of parts: every drawn part, its mass, and no cell that a spreadsheet would evaluate."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from synth.cad import EncoderDimensions, JointDimensions, SpringDimensions
from synth.cad.damper_side import damper_side
from synth.cad.layout import place
from synth.cad.standard_part import CutPart, StandardPart, made_from, screw
from synth.design import bom
from synth.design.bom import BomLine, write_bom
from synth.design.choose_springs import SpringOption
from synth.files.text_forms import defused
from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow


@pytest.mark.parametrize("cell", ["=cmd|' /C calc'!A0", "+1", "-2", "@SUM(A1)", "\t=1", "  =1", "|x", "%x", "\n=1"])
def test_spreadsheet_formulas_are_escaped(cell: str) -> None:
    assert defused(cell) == f"'{cell}"


@pytest.mark.parametrize("cell", ["6597K21", "", "music wire", "1"])
def test_plain_text_is_not_escaped(cell: str) -> None:
    assert defused(cell) == cell


KNEE = JointDimensions("knee", SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0), 110.0, 110.0, range=(80.0, 140.0))
SCREW = screw("ISO 7380-1", 3.0, 10.0)
Order = StandardPart | CutPart


def part(name: str, family: str, mass: float | None, made: str = "print") -> dict[str, object]:
    size, weight = [30.0, 4.0, 4.0], None if mass is None else {"value": mass, "unit": "g"}
    return {"part": f"hip_{name}", "joint": "hip", "family": family, "made": made, "material": "", "mass": weight,
            "box": size}  # fmt: skip


@pytest.fixture
def rows_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The rows of a hip's bill, from the lines of its springs and dampers and its drawn parts."""

    def found(
        bought: list[BomLine],
        parts: Sequence[Mapping[str, Any]],
        orders: Mapping[str, Order] = {},
        mount: bool = False,
        drawn: Sequence[object] = (),
    ) -> list[dict[str, str]]:
        monkeypatch.setattr(bom, "bought_or_wound", lambda design: bought)
        design: Any = SimpleNamespace(
            built=SimpleNamespace(joint_names=("hip",), joints=(SimpleNamespace(name="hip"),)),
            project=SimpleNamespace(cad=SimpleNamespace(mount=mount)),
            drawn=SimpleNamespace(dimensions=SimpleNamespace(joints=drawn)),
        )
        written = write_bom(
            design, parts, {f"hip_{name}": order for name, order in orders.items()}, tmp_path / "bom.csv"
        )
        assert set(written) == {part["part"] for part in parts if bought or part["family"] not in bom.LISTED}
        with (tmp_path / "bom.csv").open(newline="") as stream:
            return list(csv.DictReader(stream))

    return found


RIGHT = Catalogue.load().find_spring("LTR135H 10 M")
LEFT = replace(RIGHT, part="LTL135H 10 M", hand="left", price="5 EUR")
UNKNOWN = replace(RIGHT, hand="")


def test_a_bought_springs_line_states_the_vendors_rate_beside_that_in_the_joint() -> None:
    """LTR135H 10 M, whose clamped arms soften it: by 2.2247 N m/rad a correct spring is known on arrival."""
    (line,) = bom._spring_lines("knee", SpringOption(2.103, 2.0, row=RIGHT))
    assert line.item == "torsion spring, 2.225 N*m/rad as sold, 2.103 N*m/rad in the joint, right-hand"
    assert (line.quantity, line.part) == (1, "LTR135H 10 M")


@pytest.mark.parametrize(
    ("row", "mirror", "ends", "ordered"),
    [
        (RIGHT, LEFT, ("right-hand", "left-hand"), ("LTR135H 10 M", "LTL135H 10 M")),
        (LEFT, RIGHT, ("left-hand", "right-hand"), ("LTL135H 10 M", "LTR135H 10 M")),
        (RIGHT, None, ("right-hand", "left-hand: the mirror image of LTR135H 10 M, in no catalogue; ask for it"),
         ("LTR135H 10 M", "")),
        (UNKNOWN, None, ("one hand", "the other hand: the mirror image of LTR135H 10 M, in no catalogue; ask for it"),
         ("LTR135H 10 M", "")),
    ],
)  # fmt: skip
def test_a_bought_pair_orders_a_part_of_each_hand(
    rows_of, row: TorsionSpringRow, mirror: TorsionSpringRow | None, ends: tuple[str, str], ordered: tuple[str, str]
) -> None:
    """It ordered two of one one-handed part; of equal hands one would open where the other closes."""
    option = SpringOption(2 * 2.103, 2.0, row=row, count=2, mirror=mirror)
    lines = bom._spring_lines("hip", option)
    found = rows_of(lines, [part("spring", "spring", 3.0), part("spring_2", "spring", 3.0)])
    assert [line["item"].partition("in the joint, ")[2] for line in found] == list(ends)
    assert tuple(line["part"] for line in found) == ordered
    assert [(line["vendor"], line["quantity"], line["mass [g]"]) for line in found] == [("Lee Spring", "1", "3.00")] * 2
    assert [line["price"] for line in found] == [{"LTL135H 10 M": "5 EUR"}.get(name, "") for name in ordered]


def test_more_than_two_bought_springs_are_alike() -> None:
    (line,) = bom._spring_lines("knee", SpringOption(3 * 2.103, 2.0, row=LEFT, count=3))
    assert line.item.endswith("in the joint, all left-hand")
    assert line.quantity == 3


def test_equal_lines_are_merged_with_quantity_and_mass(rows_of) -> None:
    bought = [
        BomLine("hip", "torsion spring, 2 N*m/rad", vendor="=cmd|'/C calc'!A0", part="-LTR", quantity=2,
                source="a sheet", family="spring"),
        BomLine("hip", "rotary damper", vendor="V", part="D", source="", family="damper"),
    ]  # fmt: skip
    parts = [
        part("upper_screw_1", "screw", 1.0), part("upper_screw_2", "screw", 1.0),
        part("upper", "upper", 40.0), part("spring", "spring", 3.0), part("damper", "damper", None),
    ]  # fmt: skip
    rows = rows_of(bought, parts, {"upper_screw_1": SCREW, "upper_screw_2": SCREW}, mount=True)
    found = {row["item"]: row for row in rows}
    spring = found["torsion spring, 2 N*m/rad"]
    assert (spring["vendor"], spring["part"]) == ("'=cmd|'/C calc'!A0", "'-LTR")
    assert (spring["quantity"], spring["mass [g]"]) == ("2", "6.00")
    bolt = found["ISO 7380-1 - M3 x 10, steel"]
    assert (bolt["quantity"], bolt["mass [g]"], bolt["vendor"]) == ("2", "2.00", "any")
    assert next(row for row in rows if row["item"].startswith("heat-set insert M3"))["quantity"] == "2"
    assert found["rotary damper"]["mass [g]"] == ""
    assert (bolt["standard"], bolt["size"], bolt["length [mm]"]) == ("ISO 7380-1", "M3", "10")
    mount = next(row for row in rows if row["item"].startswith("M4 screw for the mount"))
    assert (mount["quantity"], mount["vendor"]) == ("4", "any")
    assert sum(row["item"].startswith("torsion spring") for row in rows) == 1  # not again as a drawn part


@pytest.mark.parametrize(("count", "mass", "whole"), [(50, 0.004, "0.20"), (16, 0.1255, "2.01")])
def test_masses_are_added_before_they_are_rounded(rows_of, count: int, mass: float, whole: str) -> None:
    """Rounded ones gave 0.00 and 2.08 g."""
    names = [f"screw_{k}" for k in range(count)]
    rows = rows_of([], [part(name, "screw", mass) for name in names], dict.fromkeys(names, SCREW))
    assert [(row["quantity"], row["mass [g]"]) for row in rows if row["standard"]] == [(str(count), whole)]


@pytest.mark.parametrize(
    "order",
    [
        SCREW,
        screw("ISO 4762", 3.0, 30.0, has_nut=True),
        screw("ISO 7380-1", 3.0, 12.0, washer="ISO 7089"),
        StandardPart("bearing", "ISO 15", "628/8-2Z", " ball bearing, 8 x 16 x 5 mm"),
        CutPart("tube", "20 x 2", 140.04, "drilled"),
    ],
    ids=str,
)
def test_no_column_depends_on_the_words(rows_of, order: Order) -> None:
    """Standard, size, length, quantity, and whether there is an insert or a washer, were parsed from the sentence."""
    columns = ("how", "standard", "size", "length [mm]", "quantity", "mass [g]")
    other = replace(order, words=" nut: set screw, M9 x 9") if isinstance(order, StandardPart) else order
    other = replace(other, work="cut from nut - M3 x 3") if isinstance(other, CutPart) else other
    told, untold = ([[row[name] for name in columns] for row in rows_of([], [part("p", "screw", 1.0)], {"p": each})]
                    for each in (order, other))  # fmt: skip
    assert told == untold
    assert made_from(json.loads(json.dumps(order.as_json()))) == order


def test_each_line_of_a_pair_is_for_its_own_drawn_spring(rows_of) -> None:
    """The page shows beside a drawn part the line by which it is ordered."""
    lines = bom._spring_lines("hip", SpringOption(4.2, 2.0, row=RIGHT, count=2, mirror=LEFT))
    drawn = [part("spring", "spring", 3.0), part("spring_2", "spring", 3.0)]
    found = [bom._with_drawn(line, drawn) for line in lines]
    assert [line.drawn for line in found] == [("hip_spring",), ("hip_spring_2",)]


def test_every_line_has_its_ordering_data(rows_of) -> None:
    wire = BomLine("hip", "music wire", "wind", size="2 mm", length="600", vendor="any", family="spring")
    orders = {
        "bearing_a": StandardPart("bearing", "ISO 15", "628/8-2Z", " ball bearing, 8 x 16 x 5 mm, two shields"),
        "pin": StandardPart("pin", "ISO 8734", "2.5", " dowel pin, steel", 24.0),
        "collar_a": StandardPart("collar", "DIN 705 A", "8", " shaft collar, steel, with set screw M4"),
        "thrust_washer_a": StandardPart("shim", "DIN 988", "8 x 14 x 0.5", " shim ring, steel"),
        "upper_socket_screw": screw("ISO 4762", 3.0, 30.0, has_nut=True),
        "seat_screw_1": screw("ISO 7380-1", 3.0, 12.0, washer="ISO 7089"),
        "shaft": CutPart("ground rod, h6", "8", 76.2, "drilled for its pins"),
    }
    parts = [part(name, "shaft" if name == "shaft" else "screw", 1.0) for name in orders]
    printed = {**part("upper", "upper", 46.2), "volume": {"value": 38.5e3, "unit": "mm^3"}}
    rows = rows_of([wire], [*parts, printed], orders)
    found = {(row["standard"], row["size"], row["length [mm]"], row["how"]) for row in rows}
    assert {
        ("ISO 15", "628/8-2Z", "", "buy"), ("ISO 8734", "2.5", "24", "buy"), ("DIN 705 A", "8", "", "buy"),
        ("DIN 988", "8 x 14 x 0.5", "", "buy"), ("ISO 4762", "M3", "30", "buy"), ("ISO 7380-1", "M3", "12", "buy"),
        ("ISO 7089", "3", "", "buy"), ("", "8", "79.2", "cut"), ("", "2 mm", "600", "wind"),
    } <= found  # fmt: skip
    inserts = [row for row in rows if row["item"].startswith("heat-set insert")]
    # The screw with a nut needs none.
    assert [(row["size"], row["quantity"], row["mass [g]"]) for row in inserts] == [("M3", "1", "0.34")]
    assert {row["vendor"] for row in rows} <= {"any", "", "ruthex"}
    assert not any("ruthex" in row["item"] for row in rows)  # a vendor stands in the vendor's column only
    time = next(row for row in rows if row["how"] == "print")
    assert float(time["print time [h]"]) == pytest.approx(3 + 4 / 60, abs=0.05)


def test_an_angle_sensor_s_magnet_is_ordered(rows_of) -> None:
    """Its pocket was in the shaft, and no line named it; the order of the shaft did not say that it is bored."""
    joint = replace(KNEE, name="hip", encoder=EncoderDimensions(magnet_diameter=6.0, magnet_depth=2.0))
    rows = rows_of([], [part("upper", "upper", 46.2)], drawn=[joint])
    (magnet,) = [row for row in rows if row["item"].startswith("magnet")]
    assert (magnet["joint"], magnet["size"], magnet["length [mm]"], magnet["vendor"]) == ("hip", "6 mm", "2", "any")
    assert "across its diameter" in magnet["item"]
    assert not any("magnet" in row["item"] for row in rows_of([], [part("upper", "upper", 46.2)], drawn=[KNEE]))
    for drawn, bored in ((joint, True), (KNEE, False)):
        shaft = damper_side(drawn, place(drawn))[0]
        assert isinstance(shaft.made, CutPart)
        assert ("other end bored 6 mm, 2 mm deep for the magnet" in shaft.made.work) == bored


def test_a_drawn_part_s_line_in_words() -> None:
    """As the page of the leg shows it beside the part."""
    line = BomLine("hip", "rotary damper", vendor="V", part="D", quantity=2, source="", family="damper")
    assert str(line) == "rotary damper, V, D (2 in the bill)"


def test_sentences_of_parts_to_buy() -> None:
    """As they stand in ``design.json``."""
    assert str(SCREW) == "buy: ISO 7380-1 - M3 x 10, steel"
    assert str(screw("ISO 7380-1", 2.5, 12.0, washer="ISO 7089")).endswith(
        "M2.5 x 12, steel, with washer ISO 7089 - 2.5"
    )
    assert str(screw("ISO 4762", 3.0, 30.0, has_nut=True)) == "buy: ISO 4762 - M3 x 30, steel; with nut"
    assert str(screw("ISO 4026", 3.0, 6.0, kind="set screw")) == "buy: ISO 4026 - M3 x 6 set screw, steel"
    shaft = CutPart("ground rod, h6", "8", 76.24, "drilled for its pins")
    assert str(shaft) == "cut from ground rod, h6, 8 mm, 76.2 mm long; drilled for its pins"
