"""How far a joint folds: gaps of the outlines equal those of the solids, and a stated allowed range is free."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from cad_joints import cleared
from synth.cad import DimensionError, JointDimensions, MountDimensions, SpringDimensions, checked_layout
from synth.cad.checked_layout import lay_out
from synth.cad.hinge import build_lower, build_upper
from synth.cad.layout import JointLayout, place
from synth.cad.outline import Disc, hull_of
from synth.cad.outlines import lower_bodies, upper_bodies

HIP = cleared(
    JointDimensions("hip", SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0), 110.0, 110.0, range=(80.0, 140.0))
)
FLANGED = replace(HIP, mount=MountDimensions())


def block(x: float, y: float, half: float, end: float):
    return hull_of([Disc(x + i, y + j, 0.0) for i in (-half, half) for j in (-end, end)])


def test_gap_of_hulls_equals_the_closed_form():
    square = block(0.0, 0.0, 1.0, 1.0)
    assert square.gap(block(5.0, 0.5, 1.0, 1.0)) == pytest.approx(3.0)
    assert square.gap(hull_of([Disc(4.0, 5.0, 2.0)])) == pytest.approx(3.0)  # corner to disc: 5 - 2
    assert hull_of([Disc(0, 0, 1)]).gap(hull_of([Disc(3, 4, 1), Disc(30, 4, 1)])) == pytest.approx(3.0)
    turned = square.turned(45.0)
    assert turned.gap(block(5.0, 0.0, 1.0, 1.0)) == pytest.approx(4.0 - math.sqrt(2.0))


def test_crossed_hulls_overlap_though_no_corner_lies_in_the_other():
    assert block(0.0, 0.0, 1.0, 9.0).gap(block(0.0, 0.0, 9.0, 1.0)) < -1.0


def test_clear_of_agrees_with_the_gap():
    square = block(0.0, 0.0, 1.0, 1.0)
    for turn in range(0, 90, 7):
        other = block(3.5, 0.7, 1.2, 0.4).turned(4.0 * turn)
        gap = square.gap(other)
        assert square.clear_of(other, gap)
        assert not square.clear_of(other, math.nextafter(gap, math.inf))


def test_joint_layouts_are_cached(monkeypatch):
    """Sizing, layout and weighing need each about four times; failures are cached too."""
    placed = []
    monkeypatch.setattr(checked_layout, "place", lambda d: placed.append(d) or place(d))
    fits, not_so = replace(HIP, rest_angle=111.25), replace(HIP, range=(-20.0, 140.0), rest_angle=111.25)
    assert lay_out(fits) is lay_out(replace(fits))
    said = []
    for _ in range(2):
        with pytest.raises(DimensionError) as error:
            lay_out(not_so)
        said.append(str(error.value))
    assert said[0] == said[1]
    assert placed.count(fits) == 1
    assert len(placed) <= 2


def link_gap(dimensions: JointDimensions, layout: JointLayout, rotation: float) -> float:
    """Smallest gap (mm) between both links, stem and web at a ``rotation`` (deg) from straight.

    In the canonical frame; 0 or negative if they collide.
    """
    upper = upper_bodies(dimensions, layout)
    turned = [hull.turned(rotation) for hull in lower_bodies(dimensions, layout)]
    return min(a.gap(b) for a in upper for b in turned)


@pytest.mark.parametrize("dimensions", [HIP, FLANGED], ids=["socket", "flange"])
@pytest.mark.parametrize("way", [-1, 1])
def test_gap_of_outlines_equals_that_of_the_solids(dimensions, way):
    layout = lay_out(dimensions)
    layout = replace(layout, stops=tuple(replace(stop, outer=1.0) for stop in layout.stops))  # which touch first
    upper, lower = build_upper(dimensions, layout), build_lower(dimensions, layout)
    rotation = next(
        way * turn for turn in range(180) if link_gap(dimensions, layout, way * turn) < dimensions.clearance
    )
    rotation -= way * 1.0  # the ears' gap is the clearance everywhere: under it only what folds can be seen
    closer = rotation
    while link_gap(dimensions, layout, closer) > 0.8 * dimensions.clearance:
        closer += way * 0.02
    wanted = link_gap(dimensions, layout, closer)
    assert wanted > 0.0
    assert upper.distance(lower.rotate((0, 0, 0), (0, 0, 1), closer)) == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_range_into_the_flange_is_refused_and_the_stated_range_accepted(sign):
    folded = replace(FLANGED, sign=sign, range=(40.0, 140.0), mount=MountDimensions(spacing_across=120.0))
    with pytest.raises(DimensionError, match=r"hip\.range = \(40.*the web or the mount's flange") as refused:
        lay_out(folded)
    low = float(re.search(r"allowed is ([0-9.]+) to", str(refused.value))[1])
    assert 45.0 < low < 80.0
    layout = lay_out(cleared(replace(folded, range=(low, 140.0))))  # which refuses it unless it is free
    gap = link_gap(folded, layout, low - 3.0 - folded.zero_angle)
    assert folded.clearance <= gap < folded.clearance + 0.2
