"""What makes a spring last and lets it be wound: fatigue, arms, spring-back, tolerance, hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as some

from synth.errors import UserError
from synth.parts.catalogs import Catalogue
from synth.spring import fatigue, winding
from synth.spring.design import design_spring
from synth.spring.evaluate import check_spring, travel_limit
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_search import ENDLESS, candidates, endurance
from synth.spring.spring_task import SpringLimits, SpringTask


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def wish(**limits: object) -> SpringRequirements:
    return SpringRequirements(
        1.7,
        math.radians(60),
        included_angle=math.radians(120),
        limits=SpringLimits(arbor_diameter=0.012, **limits),  # type: ignore[arg-type]
    )


class TestFatigue:
    def test_about_zero_the_wire_bears_its_endurance(self) -> None:
        assert fatigue.gerber_amplitude(400e6, 1800e6, 100e6, 0.0) == 400e6

    @given(amplitude=some.floats(1.0, 100.0), mean=some.floats(0.1, 150.0))
    def test_the_permissible_stress_lies_on_gerber_s_parabola(self, amplitude: float, mean: float) -> None:
        borne = fatigue.gerber_amplitude(78.5, 294.4, amplitude, mean)
        assert borne / 78.5 + (borne * mean / amplitude / 294.4) ** 2 == pytest.approx(1.0, rel=1e-9)

    def test_repeated_stress_is_borne_as_often_as_the_table_says(self) -> None:
        """Stress from zero to Sr: amplitude and mean Sr/2, factor one, by construction of Se."""
        known = fatigue.life(fatigue.Fatigue(0.53, 0.50, ""), 1800e6, 0.0, 0.50 * 1800e6)
        assert known is not None
        assert known.factor_1e6 == pytest.approx(1.0, rel=1e-9)
        assert known.factor(1e6) == known.factor_1e6
        assert known.factor(1e5) == known.factor_1e5

    def test_cycles_take_thicker_wire_and_are_kept(self, catalogue: Catalogue) -> None:
        once, often = design_spring(wish(), catalogue).best, design_spring(wish(cycles=1e6), catalogue).best
        assert once is not None
        assert often is not None
        assert once.life is not None
        assert often.life is not None
        assert once.life.factor_1e6 < 1.0 <= often.life.factor_1e6
        assert often.wire_diameter > once.wire_diameter
        assert once.life.factor_1e5 >= 1.0  # what a spring is designed for where nothing is asked
        assert often.warnings == ()

    def test_the_binding_limit_is_named_and_a_smaller_travel_that_lasts(self, catalogue: Catalogue) -> None:
        asked = wish(cycles=1e6, max_outer_diameter=0.02, max_body_length=0.02)
        result = design_spring(asked, catalogue)
        assert result.best is None
        assert any("strength over stress for 1e+06 cycles" in text for text in result.binding)
        smaller = next(item.design for item in result.nearest if item.kind == "smaller_travel")
        assert smaller.feasible
        assert smaller.life is not None
        assert smaller.life.factor_1e6 == pytest.approx(1.0, abs=0.02)
        assert travel_limit(smaller, asked.limits) >= smaller.travel

    def test_longest_life_is_the_longest_of_all_that_can_be_wound(self, catalogue: Catalogue) -> None:
        asked = SpringRequirements(
            1.7, math.radians(60), objective="life", limits=SpringLimits(0.012, max_outer_diameter=0.03)
        )
        result = design_spring(asked, catalogue)
        assert result.best is not None
        every = [each for each in candidates(asked, catalogue.find_material("music")) if each.feasible]
        assert endurance(result.best) == max(endurance(each) for each in every)
        lightest = design_spring(SpringRequirements(1.7, math.radians(60), limits=asked.limits), catalogue).best
        assert lightest is not None
        assert endurance(result.best) > endurance(lightest)
        assert endurance(result.best) <= ENDLESS

    @pytest.mark.parametrize(("cycles", "repeated"), [(1e6, 0.50), (1e5, 0.53)])
    def test_a_spring_opened_farther_than_it_lasts_turns_as_far_either_way(
        self, catalogue: Catalogue, cycles: float, repeated: float
    ) -> None:
        """Its opening travel shrinks with the winding one, so its stress swings about zero: it bears Se there.

        By Gerber through the stress Sr repeated from zero (Shigley, table 10-10): Se = Sr/2 / (1 - (Sr/2 Sut)^2).
        """
        music, mean, coils, wire = catalogue.find_material("music"), 26e-3, 6.25, 2.54e-3
        design = check_spring(music, wire, mean, coils, SpringTask(1.2, opening_travel=1.2))
        index, strength = mean / wire, 271 * 6.894757e6  # Pa, by the maker's table
        inner = (4 * index**2 - index - 1) / (4 * index * (index - 1))
        per_angle = inner * 196.5e9 * wire / (2.0 * math.pi * mean * coils)  # Pa/rad: Ki E d / (2 pi D N)
        endurance_limit = repeated / 2 / (1 - (repeated / 2) ** 2) * strength
        lasting = travel_limit(design, SpringLimits(cycles=cycles, fatigue_safety=1.0))
        assert lasting == pytest.approx(endurance_limit / per_angle, rel=1e-4)
        assert lasting < design.opening_travel

    def test_wire_of_which_no_fatigue_is_known_is_refused(self, catalogue: Catalogue) -> None:
        task = SpringTask(0.5, limits=SpringLimits(cycles=1e5))
        music = catalogue.find_material("music")
        unknown = replace(music, records=tuple(replace(r, repeated_bending_limit_1e6=None) for r in music.records))
        spring = check_spring(unknown, 2e-3, 20e-3, 5.0, task)
        assert spring.life is None
        assert any("no fatigue data are known" in violation.text for violation in spring.violations)

    def test_more_cycles_than_are_known(self, catalogue: Catalogue) -> None:
        with pytest.raises(UserError, match="1e6 cycles"):
            design_spring(wish(cycles=1e7), catalogue)


class TestArms:
    def test_the_bend_of_a_radial_arm_can_bind(self, catalogue: Catalogue) -> None:
        music = catalogue.find_material("music")
        limits = SpringLimits(bend_radius=0.5e-3, index_range=(4, 25))
        tangent, radial = (
            check_spring(music, 2e-3, 40e-3, 5.0, SpringTask(2.3, 0.0, (0.0, 0.0), kind, limits))
            for kind in ("tangent", "radial")
        )
        assert tangent.arm_stress < tangent.stress < tangent.allowed_stress
        # r = d/4: (0.5 + 1.07) / (0.5 + 0.25)
        assert radial.arm_stress == pytest.approx(1.57 / 0.75 * tangent.arm_stress)
        assert {violation.limit for violation in radial.violations} == {"arms"}


class TestWinding:
    def test_plastic_moment_goes_from_elastic_to_fully_plastic(self) -> None:
        # Elastic: s pi d^3 / 32 = (pi / 4) s r^3; fully plastic: s d^3 / 6 = (4 / 3) s r^3.
        assert winding.plastic_moment(1.0) == pytest.approx(math.pi / 4)
        assert winding.plastic_moment(1e-6) == pytest.approx(4 / 3)
        assert winding.plastic_moment(0.0) == pytest.approx(4 / 3)

    def test_the_mandrel_is_the_handbooks_for_a_tight_coil(self) -> None:
        """1/D_m = 1/D + 1.7 s/(E d), in mean diameters."""
        mean, wire, modulus, flow = 12e-3, 2e-3, 200e9, 2000e6
        found = winding.mandrel_diameter(mean, wire, modulus, flow) + wire
        assert 1 / found == pytest.approx(1 / mean + 1.7 * flow / (modulus * wire), rel=5e-3)

    @given(index=some.floats(4.0, 20.0), flow=some.floats(1e9, 2.5e9))
    def test_a_wound_coil_springs_back_to_the_wanted_one(self, index: float, flow: float) -> None:
        wire, modulus = 2e-3, 200e9
        mean = index * wire
        wound = winding.mandrel_diameter(mean, wire, modulus, flow) + wire
        core = flow / (modulus * 2.0 / wound * wire / 2.0)
        moment = winding.plastic_moment(min(1.0, core)) * flow * (wire / 2.0) ** 3
        relaxed = 2.0 / wound - moment / (modulus * math.pi * wire**4 / 64.0)
        assert 2.0 / relaxed == pytest.approx(mean, rel=1e-9)
        assert wound < mean
        turns = winding.turns_on_mandrel(mean, wire, 5.25, wound - wire)
        assert turns * wound == pytest.approx(5.25 * mean)

    def test_tolerance_of_the_rate_is_that_of_its_parts(self) -> None:
        plus = winding.winding_tolerance(2e-3, 20e-3, 5.0, 0.01e-3)
        assert plus.mean_diameter == pytest.approx(0.51e-3)  # Lee: outer diameter 22 mm
        assert math.degrees(plus.free_angle) == pytest.approx(10.0)
        assert plus.rate == pytest.approx(math.hypot(0.02, 0.51 / 20.0, 10.0 / 360.0 / 5.0))

    def test_music_wire_is_held_to_its_lists_tolerance(self, catalogue: Catalogue) -> None:
        music = catalogue.find_material("music")
        assert music.diameter_tolerance(2.032e-3) == pytest.approx(0.0127e-3, rel=1e-3)
        assert music.diameter_tolerance(3.4e-3) == pytest.approx(0.0254e-3, rel=1e-3)

    @pytest.mark.parametrize(("clockwise", "hand"), [(True, "right"), (False, "left")])
    def test_the_hand_whose_coil_work_closes(self, clockwise: bool, hand: str) -> None:
        """A right-hand helix, seen from its near end, goes away clockwise; turning the far end on winds it."""
        assert winding.hand_for(closes_clockwise=clockwise) == hand
        sense = -1.0 if hand == "right" else 1.0  # angle of the far end, seen from the near one, counter-clockwise +
        turns_before = 5.0
        far_end = sense * math.tau * turns_before
        moved = far_end + (-1.0 if clockwise else 1.0) * 0.5
        assert abs(moved) > abs(far_end)
