"""Dampers side by side, in pairs and behind gears: the torque that the joint feels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.parts.arrangement import Arrangement, arrangements
from synth.parts.catalogs import Catalogue
from synth.parts.rows import DamperRow
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Damper

SPEED = np.array([0.05, 0.3, 1.0, 2.7, 6.0])


@pytest.fixture(scope="module")
def row() -> DamperRow:
    return Catalogue.load().find_damper("6597K19")


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("count", [1, 2])
def test_gear_and_number_multiply_torque_and_speed(row: DamperRow, ratio: float, count: int) -> None:
    """N T(n w), times how many."""
    single = row.damper()
    together = Arrangement(count, ratio).at_joint(single)
    assert single.curve is not None
    assert together.curve is not None
    expected = count * ratio * torque_at(single.curve, ratio * SPEED)
    assert torque_at(together.curve, SPEED) == pytest.approx(expected, rel=1e-12)


def test_a_linear_damper_counts_the_ratio_squared() -> None:
    assert Arrangement(2, 3.0).at_joint(Damper(rate=0.1)).rate == pytest.approx(2 * 9 * 0.1)


def test_one_way_dampers_serve_both_ways_in_a_pair(row: DamperRow) -> None:
    """What damps one way gives its torque each way, and the other its reverse torque on top."""
    one_way = replace(row, direction="clockwise", max_torque=2.0, reverse_torque=0.5)
    (pair,) = arrangements(one_way, 2, (1.0,), "both")
    assert pair.pair
    assert pair.pieces == 2
    single, both = one_way.damper("linear"), pair.at_joint(one_way.damper("linear"))
    assert both.rate == pytest.approx(1.25 * (single.rate or 0.0))
    assert pair.words("D") == "a pair of D, one each way"
    assert arrangements(one_way, 1, (1.0,), "both") == []
    assert [a.pair for a in arrangements(one_way, 1, (1.0,), "one")] == [False]


def test_every_number_with_every_ratio(row: DamperRow) -> None:
    found = arrangements(row, 3, (2.0, 1.0, 2.0), "both")
    assert [(a.count, a.ratio) for a in found] == [(1, 1.0), (1, 2.0), (2, 1.0), (2, 2.0), (3, 1.0), (3, 2.0)]
    assert found[3].words("D") == "2 x D, turning 2 times as fast"
    assert found[0].words("D") == "D"
