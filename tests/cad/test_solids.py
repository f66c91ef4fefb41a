"""Each part against closed forms that do not come from the kernel."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from synth.cad import SpringDimensions
from synth.cad.arm_shaft import (
    ShaftShape,
    build_section,
    build_shaft,
    circumradius,
    cross_volume,
    milled_area,
    section_area,
    shaft_volume,
)
from synth.cad.checks import measured_arms
from synth.cad.outline import Disc, hull_of
from synth.cad.parts import Mesh
from synth.cad.torsion_spring import build_spring, spring_mesh, spring_volume, wire_length

KNEE = SpringDimensions(3.429, 26.035, 7.17, 120.0)
ANKLE = SpringDimensions(2.032, 17.018, 6.17, 120.0)
HIP = SpringDimensions(4.7625, 36.5, 1.04, 165.6)
OPEN = SpringDimensions(1.0, 10.0, 2.75, 270.0, pitch=3.0)


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("spring", [KNEE, ANKLE, HIP, OPEN], ids=["knee", "ankle", "hip", "open"])
def test_spring_is_one_solid_of_the_wire_s_volume_and_angle(spring, hand):
    spring = replace(spring, hand=hand)
    solid = build_spring(spring, 25.4)
    assert len(solid.Solids()) == 1
    assert solid.isValid()
    assert solid.Volume() == pytest.approx(math.pi / 4 * spring.wire_diameter**2 * wire_length(spring, 25.4), rel=1e-5)
    low, high = measured_arms(solid)
    # A right-hand coil turns the lower arm counter-clockwise of the upper one by the included angle.
    between = (low.seen_angle() - high.seen_angle()) * spring.hand_sign % 360.0
    assert between == pytest.approx(spring.included_angle, abs=1e-6)
    box = solid.BoundingBox()
    assert box.zmax - box.zmin >= spring.drawn_coils * spring.drawn_pitch
    for arm in (low, high):  # tangent: the arm's line passes the axis at the mean radius
        along = arm.direction[:2] / np.linalg.norm(arm.direction[:2])
        across = along[0] * arm.point[1] - along[1] * arm.point[0]
        assert abs(across) == pytest.approx(spring.radius, abs=1e-6)


def test_wire_length_of_a_flat_coil_is_its_circumference():
    flat = SpringDimensions(1.0, 20.0, 3.0, 180.0, pitch=1.01)
    assert wire_length(flat, 0.0) == pytest.approx(3 * math.sqrt((20 * math.pi) ** 2 + 1.01**2))


def test_hands_are_mirror_images():
    right, left = build_spring(KNEE, 20.0), build_spring(replace(KNEE, hand="left"), 20.0)
    mirrored = right.mirror("XZ")
    assert left.intersect(mirrored).Volume() == pytest.approx(right.Volume(), rel=1e-4)


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("spring", [KNEE, ANKLE, HIP, OPEN])
def test_spring_mesh_is_closed_and_has_the_volume(spring, hand):
    import trimesh

    spring = replace(spring, hand=hand)
    vertices, faces = spring_mesh(spring, 20.0)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(spring_volume(spring, 20.0), rel=4e-3)


def test_mesh_transformations_keep_the_volume():
    vertices, faces = spring_mesh(ANKLE, 10.0)
    mesh = Mesh(vertices, faces)
    for moved in (mesh.turned(33.0, (1.0, 2.0, 3.0)), mesh.scaled((-1, 1, 1)), mesh.scaled((-1, 1, -1))):
        assert moved.volume == pytest.approx(mesh.volume)


def test_hull_of_two_equal_discs_is_a_slot():
    hull = hull_of([Disc(0, 0, 2), Disc(10, 0, 2)])
    assert hull.area == pytest.approx(40 + 4 * math.pi)
    assert hull.extrude(1.0, 4.0).Volume() == pytest.approx(3 * (40 + 4 * math.pi))


def test_hull_drops_interior_and_collinear_discs():
    square = [Disc(x, y, 1.0) for x in (0, 5, 10) for y in (0, 5, 10)]
    hull = hull_of([*square, Disc(5, 5, 1.0), Disc(4, 4, 0.5)])
    assert hull.area == pytest.approx(100 + 40 + math.pi)
    assert len(hull.tangents) == 4


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(0.5, 8)), min_size=1, max_size=6))
@example([(0.0, 0.0, 1.0), (0.0, 6e-8, 1.0)])  # nearer than the modeller's tolerance: they are one disc
@example([(0.0, 0.0, 1.0), (0.0, 1e-7, 1.0)])
@example([(0.0, 0.0, 1.0), (0.0, 3e-7, 1.0)])
@example([(0.0, 0.0, 2.0), (0.0, 1.0 + 3e-7, 1.0)])
def test_hull_area_is_that_of_the_solid_and_of_the_sampled_points(discs):
    hull = hull_of([Disc(*disc) for disc in discs])
    angle = np.linspace(0, 2 * np.pi, 14401)
    # Support function of the convex hull, h; its area is 1/2 integral of h (h + h'') = 1/2 integral h^2 - h'^2.
    support = np.max([x * np.cos(angle) + y * np.sin(angle) + r for x, y, r in discs], axis=0)
    slope = np.diff(support) / np.diff(angle)
    middle = (support[1:] + support[:-1]) / 2
    area = 0.5 * np.sum((middle**2 - slope**2) * np.diff(angle))
    assert hull.area == pytest.approx(area, rel=2e-3)
    assert hull.extrude(0.0, 1.0).Volume() == pytest.approx(hull.area, rel=1e-6)


@pytest.mark.parametrize("form", ["round", "d", "square", "hex"])
def test_section_areas_equal_the_closed_form(form):
    """Areas against the kernel's solids, plain and milled from a rod whose corners they pass."""
    for grow in (0.0, 0.1, -0.1):
        assert build_section(form, 8.0, grow, -1.0, 4.0).Volume() == pytest.approx(5 * section_area(form, 8.0, grow))
    for size in (4.0, 6.2, 7.0, 8.0):
        shape = ShaftShape(8.0, -20.0, 10.0, form, size, 6.0, (), (0.0, 0.0))
        assert build_shaft(shape).Volume() == pytest.approx(shaft_volume(shape), rel=1e-7)
        assert milled_area(form, size, 8.0) <= math.pi * 16.0 + 1e-9
    assert circumradius("square", 8.0) == pytest.approx(4.0 * math.sqrt(2.0))
    assert circumradius("hex", 9.0) == pytest.approx(9.0 / math.sqrt(3.0))


def test_the_area_of_a_d_section_is_disc_minus_segment():
    x = np.linspace(-4, 3.2, 200_001)  # a D of 8 mm with a flat at 3.2, by numerical integration
    chord = 2 * np.sqrt(16 - x**2)
    assert section_area("d", 8.0) == pytest.approx(float(np.sum((chord[1:] + chord[:-1]) / 2 * np.diff(x))), rel=1e-5)


def test_the_volume_of_a_shaft_with_pins_and_pocket_equals_the_closed_form():
    shape = ShaftShape(8.0, -20.0, 30.0, "square", 6.0, 8.0, ((0.0, 2.5, 30.0), (-8.0, 2.0, 90.0)), (4.0, 2.5))
    solid = build_shaft(shape)
    assert solid.isValid()
    # The kernel integrates where pins cross the rod with a fixed number of points only.
    assert solid.Volume() == pytest.approx(shaft_volume(shape), rel=1e-5)
    # Two equal cylinders that cross share Steinmetz' 16 r^3/3.
    assert cross_volume(2.0, 0.0, 2.0) == pytest.approx(16 * 2.0**3 / 3, rel=1e-4)


def test_a_hole_of_known_sizes_is_not_integrated_again():
    """A leg's shafts, sockets and tubes have a dozen holes, drawn or weighed six times."""
    cross_volume(2.5, 1.5, 0.75)
    before = cross_volume.cache_info().hits
    assert cross_volume(2.5, 1.5, 0.75) == cross_volume(2.5, 1.5, 0.75)
    assert cross_volume.cache_info().hits == before + 2
