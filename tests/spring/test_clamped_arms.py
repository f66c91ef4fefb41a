"""A spring whose arms the joint clamps: the wire bears more than the torque, and the coil keeps its drawn pitch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from synth.cad.flexed_wire import effective_length, flex_wire
from synth.parts.catalogs import Catalogue
from synth.spring.codes import OPENING
from synth.spring.design import design_spring
from synth.spring.evaluate import check_spring, travel_limit
from synth.spring.sizes_alone import surely_broken
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringDesign
from synth.spring.spring_task import SpringLimits, SpringTask
from synth.spring.stress import bending_stress
from synth.spring.wire_load import LEAST_RATIO, PeakRatios, WireLoad

KNEE = (4.318e-3, 57.185e-3, 3.1667)  # wire, mean diameter (m), coils
RATE = 5.302  # N m/rad, with these arms


def arm(wire: float, mean: float, coils: float) -> float:
    return 33.1e-3


CLAMPED = SpringTask(
    math.radians(44.07), math.radians(32.14), limits=SpringLimits(cycles=1e5), free_arm=arm, pitch=1.03
)


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def checked(catalogue: Catalogue, task: SpringTask, sizes: tuple[float, float, float] = KNEE) -> SpringDesign:
    return check_spring(catalogue.find_material("music"), *sizes, task, stated_rate=RATE)


def peak_in_shape(angle: float) -> float:
    """Largest moment (N m) in the coil of the bent shape, with the rigidity of the spring's rate."""
    _, mean, coils = KNEE
    size = (mean * 500.0, coils, arm(*KNEE) * 1e3)
    wire = flex_wire(*size, math.degrees(angle))
    assert wire is not None
    bent = wire.curvature[wire.first : wire.last] - 1.0 / size[0]
    return float(np.abs(bent).max()) * RATE * effective_length(*size)


def test_clamped_arms_raise_stress_and_shorten_life(catalogue: Catalogue) -> None:
    """The knee's spring was said to last 1e5 turns (1.02) and to yield at 107 deg; with the peaks it does neither."""
    free = checked(catalogue, replace(CLAMPED, free_arm=None))
    held = checked(catalogue, CLAMPED)
    assert free.life is not None
    assert held.life is not None
    assert free.life.factor_1e5 == pytest.approx(1.024, abs=2e-3)
    assert held.life.factor_1e5 == pytest.approx(0.858, abs=5e-3)
    assert {each.limit for each in held.violations} == {"fatigue"}
    assert math.degrees(free.free_travel) == pytest.approx(107.0, abs=0.1)
    assert held.stress / free.stress == pytest.approx(1.176, abs=3e-3)
    assert [b.stress / a.stress for a, b in zip(free.codes, held.codes, strict=True)] == pytest.approx(
        [held.stress / free.stress] * len(held.codes)
    )
    assert held.moment == free.moment
    assert free.peak_moment == free.moment
    assert "peak_moment" in held.as_json()
    assert "peak_moment" not in free.as_json()


def test_stress_and_yield_are_those_of_the_bent_shape(catalogue: Catalogue) -> None:
    held = checked(catalogue, CLAMPED)
    wire, mean, _ = KNEE
    for angle, stress in ((held.travel, held.stress), (-held.opening_travel, held.opening_stress)):
        assert bending_stress(peak_in_shape(angle), wire, mean) == pytest.approx(stress, rel=5e-3)
    for angle, share in ((held.free_travel, 1.0), (-held.free_opening_travel, OPENING)):
        assert bending_stress(peak_in_shape(angle), wire, mean) == pytest.approx(share * held.yield_stress, rel=5e-3)
    assert held.free_opening_travel < OPENING * held.free_travel  # this coil's peak is larger when it opens
    assert held.arm_stress < held.stress


def test_free_arms_keep_the_uniform_moment() -> None:
    load = WireLoad(RATE, *KNEE)
    assert load.ratios(1.0) == PeakRatios(1.0, 1.0)
    assert load.angle(1000e6) == pytest.approx(1000e6 / load.stress(1.0))


def test_the_limit_of_the_travel_is_that_of_the_check(catalogue: Catalogue) -> None:
    for cycles in (None, 1e5):
        task = replace(CLAMPED, opening_travel=0.1, limits=SpringLimits(cycles=cycles))
        reach = travel_limit(checked(catalogue, task), task.limits)
        assert checked(catalogue, replace(task, travel=0.999 * reach)).feasible
        assert not checked(catalogue, replace(task, travel=1.001 * reach)).feasible


def test_the_quick_check_excludes_no_feasible_spring(catalogue: Catalogue) -> None:
    music, generator = catalogue.find_material("music"), np.random.default_rng(3)
    excluded = 0
    for _ in range(200):
        index, coils = generator.uniform(4.0, 20.0), generator.uniform(2.0, 9.0)
        sizes = (3e-3, 3e-3 * index, coils)
        task = SpringTask(*generator.uniform(0.2, 3.0, 2), free_arm=lambda wire, mean, coils: mean, pitch=1.03)
        broken = surely_broken(music, sizes, task)
        excluded += broken
        assert not (broken and check_spring(music, *sizes, task).feasible)
        assert min(check_spring(music, *sizes, task).peaks[k].coil for k in (0, 1)) > LEAST_RATIO
    assert excluded > 20


def test_a_designed_spring_lasts_with_the_moments_of_its_clamped_arms(catalogue: Catalogue) -> None:
    wish = SpringRequirements(
        5.3, math.radians(44.0), math.radians(32.0), math.radians(120.0), free_arm=arm, limits=SpringLimits(cycles=1e5)
    )
    held, free = (design_spring(each, catalogue).best for each in (wish, replace(wish, free_arm=None)))
    assert held is not None
    assert free is not None
    again = check_spring(catalogue.find_material("music"), *(free.wire_diameter, free.mean_diameter, free.body_coils),
                         replace(wish.task, leg_lengths=free.leg_lengths))  # fmt: skip
    assert not again.feasible
    assert held.life is not None
    assert held.life.factor_1e5 >= 1.0
    assert held.mass > free.mass


def test_the_body_keeps_its_pitch_and_its_limit_is_for_the_drawn_coil(catalogue: Catalogue) -> None:
    wire, _, coils = KNEE
    held = checked(catalogue, CLAMPED)
    turned = CLAMPED.travel / math.tau
    assert held.body_length == pytest.approx(wire * (1.0 + 1.03 * coils))
    assert held.wound_body_length == pytest.approx(wire * (1.0 + 1.03 * (coils + turned)))
    tight = replace(CLAMPED, limits=SpringLimits(max_body_length=18.7e-3))
    assert any("body length at full travel 18.95 mm" in each.text for each in checked(catalogue, tight).violations)
    assert not any(each.limit == "body_length" for each in checked(catalogue, replace(tight, pitch=1.0)).violations)
    music = catalogue.find_material("music")
    assert surely_broken(music, KNEE, tight)
    room = replace(tight.limits, max_body_length=held.wound_body_length)
    assert travel_limit(held, room) == pytest.approx(CLAMPED.travel, rel=1e-9)
