"""The lines of springs and dampers in the bill: how many to order, and what the vendor says of them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from synth.design.bom import BomLine, bought_or_wound
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.parts.arrangement import Arrangement
from synth.parts.catalogs import Catalogue
from synth.spring.evaluate import check_spring
from synth.spring.spring_task import SpringTask
from synth.swing.leg_model import Damper


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def wound(catalogue: Catalogue, count: int = 1) -> SpringOption:
    """Springs to wind, ``count`` in parallel."""
    music = catalogue.find_material("music wire")
    design = check_spring(music, 2.54e-3, 26e-3, 6.25, SpringTask(0.7), count=count)
    return SpringOption(count * design.rate, design.included_angle, design=design)


def lines(spring: SpringOption, damper: DamperOption) -> list[BomLine]:
    """The lines of a knee with these springs and dampers."""
    design: Any = SimpleNamespace(
        built=SimpleNamespace(joints=(SimpleNamespace(name="knee"),)),
        springs=SimpleNamespace(chosen=(spring,)),
        dampers=SimpleNamespace(chosen=(damper,)),
        drawn=None,
    )
    return bought_or_wound(design)


@pytest.mark.parametrize(
    ("arrangement", "pieces"),
    [
        (Arrangement(), 1),
        (Arrangement(count=3), 3),
        (Arrangement(count=1, pair=True), 2),
        (Arrangement(count=2, pair=True), 4),
    ],
)
def test_a_pair_of_one_way_dampers_is_two_to_order(catalogue: Catalogue, arrangement: Arrangement, pieces: int) -> None:
    row = catalogue.find_damper("6597K19")
    option = DamperOption(row, row.damper(), "concave", "", arrangement=arrangement)
    line = lines(wound(catalogue), option)[1]
    assert (line.quantity, line.cells()["quantity"]) == (pieces, str(pieces))
    assert ("in pairs, one for each direction" in line.item) is arrangement.pair


@pytest.mark.parametrize("part", ["6597K19", "6597K8", "6597K21"])
def test_a_damper_s_speed_is_the_one_in_its_vendor_s_words(catalogue: Catalogue, part: str) -> None:
    row = catalogue.find_damper(part)
    assert " 50 rpm max speed" in row.as_published
    (_, line) = lines(wound(catalogue), DamperOption(row, row.damper(), "concave", ""))
    assert line.item.endswith(" N*m at 50 rpm")
    assert line.part == part


@pytest.mark.parametrize(("ratio", "said"), [(1.5, "1.5"), (0.5, "0.5"), (3.0, "3")])
def test_a_geared_damper_is_said_to_turn_as_fast_as_it_does(catalogue: Catalogue, ratio: float, said: str) -> None:
    """A linear damper behind a ratio n damps by n^2: what the line says is what the joint is designed with."""
    arrangement = Arrangement(ratio=ratio)
    option = DamperOption(None, arrangement.at_joint(Damper(0.1)), "curve", "measured", arrangement=arrangement)
    line = lines(wound(catalogue), option)[1]
    assert line.item == f"rotary damper, turning {said} times as fast as the joint"
    assert option.damper.rate == pytest.approx(0.1 * float(said) ** 2)


@pytest.mark.parametrize("count", [1, 3])
def test_as_many_springs_are_wound_and_bought_as_act_together(catalogue: Catalogue, count: int) -> None:
    row = catalogue.find_spring("LTR135H 10 M")
    assert row.rate is not None
    bought = SpringOption(count * row.rate, 2.0, row=row, count=count)
    linear = DamperOption(None, Damper(0.1), "curve", "measured")
    for option, how in ((wound(catalogue, count), "wind"), (bought, "buy")):
        (line, _) = lines(option, linear)
        assert (line.how, line.quantity) == (how, count)
        assert line.item.endswith(", all right-hand") is (count > 1)
    single, several = (lines(wound(catalogue, each), linear)[0] for each in (1, count))
    assert several == replace(single, item=several.item, quantity=count)  # each is cut as long as one alone
