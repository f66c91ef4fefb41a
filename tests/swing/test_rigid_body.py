"""Bodies put together: against closed forms of rods and cylinders, and as a planar link."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.swing.leg_model import Link
from synth.swing.rigid_body import RigidBody, combined_body, link_body, offset_torque, rod_inertias


def rod(mass: float, length: float, start: float = 0.0) -> RigidBody:
    """A thin rod that hangs along -y from ``start`` m below the joint."""
    across = mass * length**2 / 12
    return RigidBody(mass, (0.0, -start - length / 2, 0.0), (across, 0.0, across, 0.0, 0.0, 0.0))


def test_two_halves_of_a_rod_are_the_rod() -> None:
    whole, halves = rod(0.4, 0.3), combined_body([rod(0.2, 0.15), rod(0.2, 0.15, 0.15)])
    assert halves.mass == pytest.approx(whole.mass)
    np.testing.assert_allclose(halves.centre, whole.centre)
    np.testing.assert_allclose(halves.inertia, whole.inertia, atol=1e-15)
    assert whole.about_hinge == pytest.approx(0.4 * 0.3**2 / 3)


def test_random_points_together_have_the_inertia_of_their_sum() -> None:
    """Against the definition, sum of m (r.r 1 - r r^T), about an axis anywhere."""
    generator = np.random.default_rng(3)
    masses, places = generator.uniform(0.1, 1.0, 7), generator.normal(size=(7, 3))
    points = [
        RigidBody(float(m), tuple(map(float, p)), (0.0,) * 6)  # type: ignore[arg-type]
        for m, p in zip(masses, places, strict=True)
    ]
    found = combined_body([combined_body(points[:3]), combined_body(points[3:])])
    centre = masses @ places / masses.sum()
    away = places - centre
    expected = sum(m * (a @ a * np.eye(3) - np.outer(a, a)) for m, a in zip(masses, away, strict=True))
    np.testing.assert_allclose(found.centre, centre)
    np.testing.assert_allclose(found.matrix, expected)
    assert found.about_hinge == pytest.approx(float(masses @ (places[:, :2] ** 2).sum(axis=1)))


def test_a_planar_link_keeps_mass_centre_and_inertia() -> None:
    body = RigidBody(0.5, (0.01, -0.12, 0.3), (1e-3, 2e-4, 1.5e-3, 1e-5, 2e-5, 3e-5))
    link = body.link(0.25)
    assert link.mass == body.mass
    assert (link.com, link.com_across) == (0.12, 0.01)
    assert link.inertia == 1.5e-3
    assert link.about_joint == pytest.approx(body.about_hinge)
    assert offset_torque(body, 9.81) == pytest.approx(0.5 * 9.81 * 0.01)


def test_a_link_as_a_body_is_that_link_again() -> None:
    link = Link(0.22, 0.2, 0.08, 1.1e-3, com_across=-0.01)
    assert link_body(link).link(0.22) == link
    across, about, along = rod_inertias(link)
    assert across + along >= about  # a body can have these
    assert about == link.inertia


def test_what_a_link_does_not_state_is_a_rod_s() -> None:
    """Across the hinge m L^2 / 12, and never less than about it."""
    slender = Link(0.3, 0.6, 0.15, 1e-3)
    assert rod_inertias(slender)[0] == pytest.approx(0.6 * 0.3**2 / 12)
    assert rod_inertias(replace(slender, inertia=5.5e-3))[0] == 5.5e-3


def test_combining_no_bodies_is_refused() -> None:
    with pytest.raises(ValueError, match="no body"):
        combined_body([])
