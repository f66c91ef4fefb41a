"""Mass, centre and inertia of parts: against closed forms, and against trimesh on the exported meshes."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
import trimesh

from synth.cad import BuiltLeg, build_leg
from synth.cad.parts import ANGULAR_TOLERANCE, LINEAR_TOLERANCE, BuiltPart, _triangles, mesh_of
from synth.cad.travel import manifold

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


def test_a_mesh_is_made_on_first_use() -> None:
    asked, box = [], cq.Solid.makeBox(1, 2, 3)

    class Solid:
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
