"""Mass, centre and inertia of parts: against closed forms, and against trimesh on the exported meshes."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
import trimesh

from synth.cad import BuiltLeg, build_leg, facets
from synth.cad.hardware import screw_of
from synth.cad.kernel import is_faceted
from synth.cad.leg_joints import build_leg_of_facets
from synth.cad.parts import ANGULAR_TOLERANCE, LINEAR_TOLERANCE, BuiltPart, _sorted_mesh, _triangles, mesh_of
from synth.cad.spring_seat import build_screw, screw_volume
from synth.cad.travel import manifold
from synth.design.solid_work import part_records

PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def test_moments_of_a_cylinder_equal_the_closed_form() -> None:
    """R 5, h 12 along x, its end at (3, 4, 5): V = pi r^2 h; about x V r^2/2, across V (3 r^2 + h^2)/12."""
    solid = cq.Solid.makeCylinder(5.0, 12.0, cq.Vector(3, 4, 5), cq.Vector(1, 0, 0))
    found = BuiltPart("c", "shaft", "lower", solid, mesh_of(solid), False, None, "cut").moments()
    volume = np.pi * 25 * 12
    along, across = volume * 25 / 2, volume * (75 + 144) / 12
    assert found.volume == pytest.approx(volume)
    assert found.centre == pytest.approx((9.0, 4.0, 5.0))
    assert found.tensor == pytest.approx((along, across, across, 0.0, 0.0, 0.0), abs=1e-6)
    assert found.about_z == pytest.approx(across)


def test_mass_and_inertia_of_every_part_equal_those_of_its_mesh(leg: BuiltLeg) -> None:
    """The mesh's chords cut a round off: volumes within 1 %, inertias within 2 %, products of inertia in sign too."""
    for joint in leg.joints:
        for part in joint.parts:
            if part.group == "spring":
                continue  # its solid is unloaded, its mesh that of the free angle; the wire's volume has a gate
            found = part.moments()
            mesh = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=True)
            size = float(np.linalg.norm(mesh.extents))
            assert found.volume == pytest.approx(float(mesh.volume), rel=0.012), part.name
            np.testing.assert_allclose(found.centre, mesh.center_mass, atol=2e-3 * size)
            # trimesh's tensor is about the centre, with density 1
            theirs = np.array([mesh.moment_inertia[place] for place in PLACES])
            np.testing.assert_allclose(found.tensor, theirs, atol=0.02 * theirs.max(), err_msg=part.name)


def test_moments_of_facets_are_those_of_the_solids(leg: BuiltLeg) -> None:
    """Every part of every joint; 1e-5 is the kernel's own error where a screw's hole crosses a tube.

    4e-5 in the damper's brackets, which keys' holes cross: a mesh of the solid with 5e-4 mm of deflection agrees with
    the facets within 1e-6.

    The facets of a spring are straight between points 2.5 deg apart: its centre is within 5e-3 mm, its inertia 3e-4.
    """
    fine = build_leg_of_facets(leg.dimensions)
    assert [part.name for part in fine.parts] == [part.name for part in leg.parts]
    for exact, quick in zip(leg.parts, fine.parts, strict=True):
        wanted, found = exact.moments(), quick.moments()
        assert is_faceted(quick.solid), quick.name
        within = 4e-5 if exact.name.endswith("damper_bracket") else 1e-5
        assert found.volume == pytest.approx(wanted.volume, rel=within), quick.name
        atol = 5e-3 if exact.family == "spring" else 1e-3
        np.testing.assert_allclose(found.centre, wanted.centre, atol=atol, err_msg=quick.name)
        error = np.abs(np.subtract(found.tensor, wanted.tensor)).max() / max(wanted.tensor)
        assert error < (3e-4 if exact.family == "spring" else 2.0 * within), (quick.name, error)


@pytest.mark.parametrize("angle", [360.0, 130.0])
def test_a_cylinder_of_facets_has_the_closed_form_of_a_sector(angle: float) -> None:
    """R 5, h 2 on (1, 2, 3): its area, and its centre 2/3 R sin(a)/a from the axis, a half of the angle."""
    found = facets.cylinder(5.0, 2.0, (1.0, 2.0, 3.0), (0.0, 0.0, 1.0), angle).moments()
    half = np.radians(angle) / 2
    reach = 10.0 / 3 * np.sin(half) / half
    assert found.volume == pytest.approx(half * 25 * 2, rel=1e-8)  # manifold3d rounds outlines to 1e-8
    assert found.centre == pytest.approx((1 + reach * np.cos(half), 2 + reach * np.sin(half), 4.0), abs=1e-3)


def test_a_prism_of_facets_may_be_concave_and_oblique() -> None:
    """An L of area 3 times the part of the way across its plane, either way round."""
    corners = [(0.0, 0.0, 1.0), (2.0, 0.0, 1.0), (2.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 2.0, 1.0), (0.0, 2.0, 1.0)]
    for way in ((0.5, 0.2, 3.0), (0.5, 0.2, -3.0)):
        for points in (corners, corners[::-1]):
            found = facets.prism(points, way).moments()
            assert found.volume == pytest.approx(9.0)
            assert found.centre == pytest.approx((5 / 6 + 0.25, 5 / 6 + 0.1, 1 + way[2] / 2))


def test_an_open_mesh_and_an_oblique_axis_are_refused() -> None:
    with pytest.raises(ValueError, match="closed"):
        facets.solid_of_mesh(np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match="axis"):
        facets.cylinder(1.0, 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 360.0).rotate((0, 0, 0), (1, 0, 0), 10.0)


def test_a_mesh_is_made_on_first_use() -> None:
    asked, box = [], cq.Solid.makeBox(1, 2, 3)

    class Solid:
        wrapped = box.wrapped

        def mesh(self, *tolerances: float) -> None:
            asked.append(tolerances)
            box.mesh(*tolerances)

        def Faces(self) -> list[cq.Face]:
            return list(box.Faces())

    mesh = mesh_of(Solid(), (-1, 1, 1))
    assert not asked
    assert mesh.volume == pytest.approx(6.0)
    assert mesh.vertices[:, 0].min() == pytest.approx(-1.0)
    assert len(asked) == 1
    with pytest.raises(AttributeError):
        mesh.colour  # noqa: B018


def test_the_order_of_a_mesh_does_not_depend_on_last_bits() -> None:
    """An edge along z, whose x differs by rounding between two runs: its points changed places in the GLB file."""
    points = np.array([[0.1, 0.0, 9.0], [0.1, 0.0, 3.0], [0.1, 0.0, -9.0], [7.0, 1.0, 0.0]])
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]])
    noisy = points + 1e-15 * np.array([[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    shuffled = np.array([2, 0, 3, 1])
    one, other = _sorted_mesh(points, faces), _sorted_mesh(noisy[shuffled], np.argsort(shuffled)[faces])
    np.testing.assert_allclose(one.vertices, other.vertices, rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(one.faces, other.faces)


def test_a_screw_in_two_places_is_one_solid_with_one_mesh() -> None:
    screw = screw_of(3.0)
    one = build_screw(screw, 12.0, 5.0, 1, (1.0, 2.0), washer=True)
    other = build_screw(screw, 12.0, -7.0, 1, (30.0, 0.0), washer=True)
    assert one.wrapped.TShape() is other.wrapped.TShape()
    low, high = mesh_of(one), mesh_of(other)
    moved = np.sort(high.vertices - (29.0, -2.0, -12.0), axis=0)
    np.testing.assert_allclose(moved, np.sort(low.vertices, axis=0), atol=1e-12)
    assert low.volume == pytest.approx(high.volume, rel=1e-12)
    end = cq.Vector(1, 2, 5 + screw.washer_thickness)
    shank = cq.Solid.makeCylinder(screw.size / 2, 12.0, end, cq.Vector(0, 0, -1))
    assert one.Volume() == pytest.approx(screw_volume(screw, 12.0, washer=True), rel=1e-9)
    assert one.intersect(shank).Volume() == pytest.approx(shank.Volume(), rel=1e-9)


def test_mesh_moments_and_body_of_a_part_are_cached(leg: BuiltLeg) -> None:
    """Gates, files and report ask for each some three times."""
    part = leg.joints[0].part("upper")
    assert part.moments() is part.moments()
    assert manifold(part.mesh) is manifold(part.mesh)
    points, faces = part.solid.tessellate(LINEAR_TOLERANCE, ANGULAR_TOLERANCE)
    ours = _triangles(part.solid)
    np.testing.assert_array_equal(ours[0], [point.toTuple() for point in points])
    np.testing.assert_array_equal(ours[1], faces)


def test_built_joints_are_cached(leg: BuiltLeg) -> None:
    alone = replace(leg.dimensions, joints=leg.dimensions.joints[:1])
    assert build_leg(alone).joints[0] is build_leg(alone).joints[0]


def test_a_part_s_record_is_that_of_its_file(leg: BuiltLeg) -> None:
    """``com`` and ``size`` in the STL's frame (free angle), ``in_link`` with the half's link along y."""
    joint = leg.joints[1]
    assert abs(joint.turn("lower", joint.dimensions.free_angle)) > 20.0
    turned = 0
    for item in part_records(leg, 1):
        part = leg.links[1] if item["family"] == "link" else joint.part(item["part"].removeprefix("knee_"))
        if "com" not in item or part.group == "spring":
            continue
        mesh = joint.mesh_at(part, joint.dimensions.free_angle)
        found = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        assert [place["value"] for place in item["com"]] == pytest.approx(found.center_mass, abs=0.1), part.name
        assert item["size"] == pytest.approx(found.extents, abs=0.01)
        straight = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
        assert [place["value"] for place in item["in_link"]["com"]] == pytest.approx(straight.center_mass, abs=0.1)
        assert item["in_link"]["size"] == pytest.approx(straight.extents, abs=0.01)
        turned += abs(item["com"][1]["value"] - item["in_link"]["com"][1]["value"]) > 1.0
    assert turned >= 2  # the lower half and its link at least


def test_a_part_s_own_size_does_not_depend_on_where_it_points(leg: BuiltLeg) -> None:
    """Identical caps had two sizes in the order list, 26.0 x 20.0 and 30.6 x 26.5 mm, as one of them stands oblique."""
    for joint in leg.joints:
        upper, lower = (joint.part(f"{half}_cap") for half in ("upper", "lower"))
        assert upper.mesh.own_size == pytest.approx(lower.mesh.own_size, abs=0.011)
        seat = joint.layout.seat
        box = sorted((2 * seat.half_width, seat.length - joint.layout.upper.relief), reverse=True)
        assert upper.mesh.own_size[:2] == pytest.approx(box, abs=0.011)
        assert upper.mesh.turned(33.0).own_size == pytest.approx(upper.mesh.own_size, abs=0.011)
    shaft = leg.joints[0].part("shaft").mesh
    assert shaft.own_size == pytest.approx(sorted(shaft.size, reverse=True), abs=0.05)
