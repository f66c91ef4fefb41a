"""What several parts side by side need of the joint's length, and a damper's travel behind the slowest gear allowed."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import pytest

from synth.files.project_options import DamperChoice, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.part_candidates import damper_reasons, spring_candidates, spring_reasons


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


@pytest.mark.parametrize(
    ("most", "against_one", "against_two"),
    [(15.0, True, True), (19.0, True, True), (35.0, False, True), (39.0, False, True), (41.0, False, False)],
)
def test_bodies_side_by_side_need_their_lengths_together(
    catalogue: Catalogue, most: float, against_one: bool, against_two: bool
) -> None:
    """Two bodies of 20 mm are 40 mm: too long for 35, which one fits."""
    row = replace(catalogue.find_spring("LTR135H 10 M"), body_length=0.020)
    for count, against in ((1, against_one), (2, against_two)):
        found = list(spring_reasons(row, SpringChoice(max_body_length=most * 1e-3), None, count=count))
        assert found == ([f"body length over {most:g} mm"] if against else [])


def test_a_pair_longer_than_the_joint_is_no_candidate(catalogue: Catalogue) -> None:
    row = replace(catalogue.find_spring("LTR135H 10 M"), body_length=0.020)
    assert row.rate is not None
    alone = replace(catalogue, springs=(row,))
    for count, kept in ((1, (row,)), (2, ())):
        found = spring_candidates(alone, SpringChoice(max_body_length=0.035), count * row.rate, count=count)
        assert found.rows == kept


def test_the_two_hands_of_one_spring_are_one_candidate(catalogue: Catalogue) -> None:
    """Sets that differ in hands alone filled the list of the next best ones."""
    right = next(row for row in catalogue.springs if row.hand == "right" and row.choosable and row.rate)
    left = replace(right, hand="left", part="OTHER")
    assert right.rate is not None
    stiffer = replace(left, rate=1.05 * right.rate, part="STIFFER")
    for rows, kept in (((right, left, stiffer), (right, stiffer)), ((left, right), (left,))):
        found = spring_candidates(replace(catalogue, springs=rows), SpringChoice(rate_tolerance=0.2), right.rate)
        assert found.rows == kept
    elsewhere = replace(left, vendor="another")
    found = spring_candidates(replace(catalogue, springs=(right, elsewhere)), SpringChoice(), right.rate)
    assert found.rows == (right, elsewhere)


@pytest.mark.parametrize(
    ("ratios", "turned"), [((1.0,), 80), ((1.0, 1.5), 80), ((1.5,), 120), ((1.5, 2.0), 120), ((0.5, 3.0), 40)]
)
def test_a_damper_is_left_out_if_even_the_slowest_gear_turns_it_too_far(
    catalogue: Catalogue, ratios: tuple[float, ...], turned: int
) -> None:
    """A joint's 80 deg times the smallest ratio, against a vane damper's 110 deg."""
    vane = replace(catalogue.find_damper("6597K19"), continuous="no", travel=radians(110.0))
    found = list(damper_reasons(vane, DamperChoice(ratios=ratios), radians(80.0)))
    assert found == ([f"turns less than {turned} deg"] if turned > 110 else [])
