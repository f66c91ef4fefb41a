"""Arms that leave the coil radially or axially: their angle and stress against a frame of straight and curved wire."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from synth.arrays import Array
from synth.parts.coil_angle import Convention
from synth.parts.coil_rate import active_coils, coil_product, mean_diameter_for, rate
from synth.spring.arms import arm_stress, lever_of

MODULUS, WIRE = 207e9, 1e-3  # Pa, m
INERTIA = math.pi * WIRE**4 / 64.0


def angle_by_castigliano(mean: float, length: float, convention: Convention) -> float:
    """Rad per N m that one arm adds: bending energy of its force at the end, a unit moment over its distance."""
    end, root = {
        "tangent": (np.array([0.5 * mean, length, 0.0]), np.array([0.5 * mean, 0.0, 0.0])),
        "radial": (np.array([0.5 * mean + length, 0.0, 0.0]), np.array([0.5 * mean, 0.0, 0.0])),
        "axial": (np.array([0.5 * mean, 0.0, length]), np.array([0.5 * mean, 0.0, 0.0])),
    }[convention]
    along = (end - root) / length
    across = np.array([0.0, 1.0, 0.0]) if convention != "tangent" else np.array([-1.0, 0.0, 0.0])
    # The force is at right angles to the arm; its moment about the axis is one.
    force = across / float(np.cross(end, across)[2])

    def bending(x: float) -> float:
        moment: Array = np.cross(end - (root + x * along), force)
        return float(moment @ moment - (moment @ along) ** 2)

    return float(quad(bending, 0.0, length)[0]) / (MODULUS * INERTIA)


@pytest.mark.parametrize("convention", ["radial", "axial"])
@pytest.mark.parametrize(("mean", "length"), [(10e-3, 25e-3), (20e-3, 8e-3)])
def test_an_arm_turns_as_far_as_its_bending_energy_says(convention: Convention, mean: float, length: float) -> None:
    coil = 64.0 * mean / (MODULUS * WIRE**4)  # rad per N m of one coil
    own = (active_coils(5.25, mean, (length, 0.0), convention) - 5.25) * coil
    assert own == pytest.approx(angle_by_castigliano(mean, length, convention), rel=1e-9)


def test_a_tangent_arm_is_that_of_the_textbooks() -> None:
    """l/3 is for a force whose moment about the axis is the arm's own: exact for arms much longer than the coil."""
    own = (active_coils(5.25, 1e-4, (0.1, 0.0)) - 5.25) * 64.0 * 1e-4 / (MODULUS * WIRE**4)
    assert own == pytest.approx(angle_by_castigliano(1e-4, 0.1, "tangent"), rel=1e-6)


@pytest.mark.parametrize("convention", ["radial", "axial"])
@pytest.mark.parametrize("lengths", [(0.0, 0.0), (5e-3, 5e-3), (3e-3, 7e-3)])
def test_the_mean_diameter_gives_the_wanted_rate(convention: Convention, lengths: tuple[float, float]) -> None:
    product = coil_product(MODULUS, WIRE, 0.05)
    for coils in (3.25, 8.25):
        mean = mean_diameter_for(product, coils, lengths, convention)
        assert mean > 0.0
        active = active_coils(coils, mean, lengths, convention)
        assert rate(MODULUS, WIRE, mean, active) == pytest.approx(0.05, rel=1e-9)
    assert mean_diameter_for(product, 8.25, (0.2, 0.2), convention) <= 0.0 or convention == "radial"


def test_an_axial_arm_bends_the_coil_s_end_both_ways() -> None:
    """The force M/R at the length l: M about the axis, M l/R about a radial line."""
    lever = lever_of("axial", (25e-3, 10e-3), 10e-3)
    assert lever == pytest.approx(5.0)
    plain, both = (arm_stress(0.02, WIRE, "axial", WIRE, each) for each in (0.0, lever))
    assert both == pytest.approx(math.sqrt(26.0) * plain)
    assert lever_of("radial", (25e-3, 10e-3), 10e-3) == lever_of("tangent", (25e-3, 10e-3), 10e-3) == 0.0
