"""Which hand each spring of a joint has: one answer for drawing, notes, bill, quotation, page and warnings."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import ezdxf
import pytest

from synth.cad import JointDimensions, SpringDimensions
from synth.cad.joint import spring_seats
from synth.cad.layout import place
from synth.design.bom import _spring_lines
from synth.design.choose_springs import SpringOption, SpringSource, WantedTravel, spring_options
from synth.design.measured_rate import rate_in_joint
from synth.design.solid_files import _how_to_test, _write_requests
from synth.design.spring_entry import spring_entry
from synth.design.spring_hands import hand_notes, hands_of, is_pair, unstated_hand
from synth.design.spring_warnings import spring_warnings
from synth.files.project_options import CadOptions, MeasuredSpring, PartsOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.part_candidates import mirror_of
from synth.parts.rows import TorsionSpringRow
from synth.parts.usable import usable_spring
from synth.remarks import remark_json, severity_of
from synth.reports.section import AbsentResult
from synth.reports.sections.spring_sheet import content
from synth.spring.evaluate import check_spring
from synth.spring.spring_task import SpringTask

KNEE = JointDimensions("knee", SpringDimensions(2.54, 26.0, 6 + 1 / 6, 120.0), 110.0, 110.0, range=(80.0, 140.0))


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def wound(catalogue: Catalogue, count: int) -> SpringOption:
    music = catalogue.find_material("music wire")
    design = check_spring(music, 2.54e-3, 26e-3, 6 + 1 / 6, SpringTask(0.7, leg_lengths=(0.025, 0.025)), count=count)
    return SpringOption(count * design.rate, design.included_angle, design=design)


@pytest.mark.parametrize(
    ("count", "hands"), [(1, ("right",)), (2, ("right", "left")), (3, ("right",) * 3), (4, ("right",) * 4)]
)
def test_two_springs_are_of_either_hand_as_drawn_and_more_are_alike(
    catalogue: Catalogue, count: int, hands: tuple[str, ...]
) -> None:
    option = wound(catalogue, count)
    assert hands_of(option) == hands
    drawn = replace(KNEE, springs=2 if is_pair(option) else 1)
    seats = spring_seats(drawn, place(drawn))
    assert [seat.spring.hand for seat, _ in seats] == list(hands[: 2 if count == 2 else 1])
    left = replace(option, design=replace(option.design, hand="left"))  # type: ignore[type-var]
    assert hands_of(left)[0] == "left"


def quotation(option: SpringOption, folder: Path) -> str:
    """The text of the quotation drawing."""
    joint = replace(KNEE, springs=2 if is_pair(option) else 1)
    drawn = SimpleNamespace(dimensions=SimpleNamespace(joints=(joint,)))
    design: Any = SimpleNamespace(springs=SimpleNamespace(chosen=(option,)), drawn=drawn)
    _write_requests(design, folder)
    document = ezdxf.readfile(folder / "knee_spring_quotation.dxf")
    return "\n".join(item.dxf.text for item in document.modelspace().query("TEXT"))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_quotation_bill_page_and_note_of_springs_to_wind_ask_for_the_same_hands(
    catalogue: Catalogue, tmp_path: Path, count: int
) -> None:
    """The quotation and the winding sheet asked for two right-hand springs, the bill for one of each hand."""
    option = wound(catalogue, count)
    pair, text = count == 2, quotation(option, tmp_path)
    asked = f"Quantity: {count}" + (": one right-hand, one left-hand, each the other's mirror image" if pair else "")
    assert asked in text.splitlines()
    assert ("coils, one right-hand, one left-hand, pitch" in text or "one left-hand, touching" in text) is pair
    assert ("coils, right-hand as drawn, and one mirrored" in text) is pair
    assert ("from the side: the right-hand one." in text) is pair
    (line,) = _spring_lines("knee", option)
    assert line.quantity == count
    assert line.item.endswith({1: "trim", 2: ", one right-hand, one left-hand", 3: ", all right-hand"}[count])
    result: Any = SimpleNamespace(content={"joints": {"knee": {"spring": spring_entry(option)}}})
    shown = content(result)
    assert not isinstance(shown, AbsentResult)
    (sheet,) = shown["sheets"]
    assert sheet["hands"] == list(hands_of(option))
    assert ("The other, left-hand: seen from either end" in sheet["winding"]["closing"]) is pair
    assert ("the one right-hand, the other left-hand, and" in sheet["winding"]["steps"][1]) is pair
    notes = hand_notes("knee", option)
    assert len(notes) == (count > 1)
    assert all(("wind one right-hand and one left-hand" in note) is pair for note in notes)
    assert all(("All are right-hand" in note) is not pair for note in notes)


def test_the_rate_to_expect_and_a_measured_one_are_of_all_springs_to_wind(catalogue: Catalogue) -> None:
    """The rate of one was to be expected of two, and the rate measured of two was taken for that of one."""
    option = wound(catalogue, 2)
    (said,) = _how_to_test(
        SimpleNamespace(  # type: ignore[arg-type]
            built=SimpleNamespace(joint_names=("knee",)), springs=SimpleNamespace(chosen=(option,))
        )
    )
    assert option.test is not None
    assert f"together: knee {2 * option.test.rate:.4g} N*m/rad at " in said
    assert rate_in_joint(MeasuredSpring(rate=2 * option.test.rate), option) == pytest.approx(option.rate)


def row_of(catalogue: Catalogue, **other: object) -> TorsionSpringRow:
    return replace(catalogue.find_spring("LTR135H 10 M"), **other)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("other", "parts", "is_mirror"),
    [
        ({}, PartsOptions(), True),
        ({"leg_length": 0.08, "body_length": None}, PartsOptions(), True),
        ({"vendor": "Alpha"}, PartsOptions(), True),
        ({"wire_diameter": 3.5e-3}, PartsOptions(), False),
        ({"rate": 2.3}, PartsOptions(), False),
        ({"included_angle": radians(90.0)}, PartsOptions(), False),
        ({"body_length": 0.045}, PartsOptions(), False),
        ({"hand": ""}, PartsOptions(), False),
        ({"hand": "right"}, PartsOptions(), False),
        ({"state": "suspect"}, PartsOptions(), False),
        ({}, PartsOptions(without=("LTL135H 10 M",)), False),
        ({"vendor": "Alpha"}, PartsOptions(vendors=("Lee Spring",)), False),
    ],
)
def test_a_mirror_has_the_other_hand_and_the_same_sizes_and_can_be_had(
    catalogue: Catalogue, other: dict[str, object], parts: PartsOptions, is_mirror: bool
) -> None:
    row = row_of(catalogue)
    left = row_of(catalogue, **{"part": "LTL135H 10 M", "hand": "left", **other})
    assert mirror_of(row, (row, left), parts) == (left if is_mirror else None)


def pair_of(catalogue: Catalogue, *rows: TorsionSpringRow) -> tuple[SpringOption, list[str]]:
    """Two of the first row where these springs are known, and the warnings on them."""
    choice, known = SpringChoice(part=rows[0].part, parallel=2), replace(catalogue, springs=rows)
    source = SpringSource("knee", choice, WantedTravel(0.3, 0.1), known, CadOptions())
    (option,), _, _ = spring_options(source, 4.4)
    return option, spring_warnings("knee", option, choice)


def test_a_bought_pair_has_a_part_of_each_hand_or_a_decisive_warning(catalogue: Catalogue) -> None:
    """Two of a right-hand part were ordered; mirrored, one of them would have to be left-hand."""
    row, left = row_of(catalogue), row_of(catalogue, part="LTL135H 10 M", hand="left")
    option, said = pair_of(catalogue, row, left)
    assert said == []
    assert (spring_entry(option)["hands"], spring_entry(option)["other_hand"]) == (["right", "left"], "LTL135H 10 M")
    assert hand_notes("knee", option)[0].endswith(
        "order one LTR135H 10 M (right-hand) and one LTL135H 10 M (left-hand)"
    )
    option, (text,) = pair_of(catalogue, row)
    assert "LTR135H 10 M is right-hand, and no catalogue has a left-hand spring of its sizes and rate" in text
    assert severity_of(text) == "decide"
    assert spring_entry(option)["other_hand"] is None
    _, (text,) = pair_of(catalogue, replace(row, hand=""), left)
    assert "the catalogue does not state the hand of LTR135H 10 M" in text


def test_a_hand_that_no_catalogue_states_is_to_be_looked_at_before_printing(catalogue: Catalogue) -> None:
    """A complete row without a hand was drawn right-hand, for information; the parts printed for it fit no other."""
    stated = row_of(catalogue)
    assert usable_spring(stated, catalogue.known_materials).measure == ()
    built_in = catalogue.find_spring("9271K621")
    assert (built_in.hand, built_in.complete, built_in.measure) == ("", True, ("hand",))
    option = SpringOption(2.1, radians(120.0), row=replace(stated, hand="", measure=("hand",)))
    assert option.row is not None
    assert spring_entry(option)["measure_before_printing"] == ["hand"]
    (said,) = unstated_hand("knee", option)
    assert severity_of(said) == "decide"
    assert "drawn right-hand" in said
    assert remark_json(said)["remedy"].startswith("Look which way it is wound before printing")
    (line,) = _spring_lines("knee", option, KNEE)
    assert "in the joint, drawn right-hand, " in line.item
    assert line.item.endswith(" (measure before printing: hand)")
    (line,) = _spring_lines("knee", option)  # nothing is drawn
    assert line.item.endswith("in the joint (measure before printing: hand)")
    known = replace(option, row=stated)
    assert unstated_hand("knee", known) == []
    assert _spring_lines("knee", known)[0].item.endswith("in the joint, right-hand")
    assert unstated_hand("knee", replace(option, count=2)) == []  # one of each hand: ``hand_warnings``
