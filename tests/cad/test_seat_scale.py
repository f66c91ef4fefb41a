"""The scale by which a seat is turned, on the solids: its pit stands by itself, whatever the joint's size."""

from __future__ import annotations

import math

import pytest

from cad_joints import cleared
from synth.cad import BoreDimensions, DamperDimensions, JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.hardware import screw_of
from synth.cad.hinge import box, build_upper, cylinder
from synth.cad.spring_seat import build_plate

LINE = 0.4  # mm, of print: less between two cuts is not printed
BESIDE = DamperDimensions(30.0, 12.0, 38.0)  # a pair's seat screws lie outside its sleeve, or inside a wide one
WIDE = DamperDimensions(44.0, 16.0, 54.0, bore=BoreDimensions(form="square", size=13.0))


def hinge(wire, diameter, *, springs=1, closes=-1, travel=13.0, damper=BESIDE, wall=3.0):
    spring = SpringDimensions(wire, diameter, 4 + 60 / 360, 120.0)
    dimensions = JointDimensions(
        "knee", spring, 115.0, 118.0, range=(95.0, 135.0), springs=springs, closes=closes, damper=damper,
        seat_travel=travel, wall=wall, link_length=320.0,
    )  # fmt: skip
    dimensions = cleared(dimensions)
    layout = lay_out(dimensions)
    return dimensions, layout, build_upper(dimensions, layout)


def pits(upper):
    """Axes and bottoms or tops (mm) of the holes of half a millimetre along the hinge axis."""
    faces = [face for face in upper.Faces() if face.geomType() == "CYLINDER"]
    found = []
    for face in faces:
        round_, box = face._geomAdaptor().Cylinder(), face.BoundingBox()
        if abs(round_.Radius() - 0.5) < 1e-9 and box.zmax - box.zmin < 1.0:
            at = round_.Axis().Location()
            found.append((at.X(), at.Y(), box.zmin, box.zmax))
    return found


@pytest.mark.parametrize(
    "joint",
    [
        {"wire": 1.6, "diameter": 18.0},  # the least radius of a scale
        {"wire": 2.032, "diameter": 17.0, "travel": 16.0, "closes": 1},
        {"wire": 2.5, "diameter": 20.0, "travel": 0.0},
        {"wire": 3.429, "diameter": 26.0, "springs": 2},
        {"wire": 3.429, "diameter": 26.0, "springs": 2, "damper": WIDE},  # heads sunk right beside the window
        {"wire": 5.5, "diameter": 42.0},
    ],
    ids=["least", "most travel", "no travel", "pair", "pair in the sleeve", "thick"],
)
def test_a_line_of_print_stands_all_round_the_pit(joint):
    dimensions, layout, upper = hinge(**joint)
    found = pits(upper)
    assert len(found) == dimensions.springs
    for x, y, low, high in found:
        assert high - low == pytest.approx(0.5, abs=1e-6)  # a whole one
        ring = cylinder(0.5 + LINE - 0.005, low, high, (x, y)).cut(cylinder(0.5, low - 1, high + 1, (x, y)))
        assert upper.intersect(ring).Volume() == pytest.approx(ring.Volume(), rel=1e-3)
        off = (math.degrees(math.atan2(y, x)) - layout.plate.window + 180.0) % 360.0 - 180.0
        assert -dimensions.closes * off > 0.6 * layout.plate.travel  # at the plus end


@pytest.mark.parametrize("wall", [1.2, 3.0], ids=["thin", "usual"])
def test_zero_is_the_longest_mark_of_ear_and_plate(wall):
    """Along each mark's line, a quarter of a millimetre deep: how far it is cut, beside what is between the marks."""
    dimensions, layout, upper = hinge(2.5, 20.0, wall=wall)
    faces = {"ear": (upper, layout.gap_b + layout.ear), "plate": (build_plate(dimensions, layout), layout.plate.top)}
    for (solid, top), step, count in zip(faces.values(), (5.0, 4.0), (4, 2), strict=True):
        lengths = {k: cut_length(solid, layout, step * k, top, wall) for k in range(-count, count + 1)}
        others = [length for k, length in lengths.items() if k]
        assert max(others) == pytest.approx(min(others), abs=1e-6)
        assert max(others) < 0.61 * lengths[0]  # told apart at a glance
        between = cut_length(solid, layout, step / 2, top, wall)
        assert between == pytest.approx(0.0, abs=1e-6)


def cut_length(solid, layout, off, top, wall):
    """Length (mm) cut along the radius, ``off`` deg from the window: beyond its outer edge (ear), or within it."""
    screw = screw_of(layout.seat.screw)
    edge = screw.washer / 2 + wall / 2 - 0.05  # of the ear, and a little less
    low, high = (screw.hole / 2, edge) if top > layout.plate.top else (-screw.hole / 2, screw.hole / 2)
    thin = box((layout.plate.radius + low, layout.plate.radius + high), (-0.02, 0.02), (top - 0.3, top - 0.2))
    tool = thin.rotate((0, 0, 0), (0, 0, 1), layout.plate.window + off)
    return (high - low) * (1.0 - solid.intersect(tool).Volume() / tool.Volume())
