"""One rate for drawn hinges that differ: equal ones give themselves, the energy of the stroke is that of all five."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

import synth
from hopper.hoppers import motor
from synth.hopper.laminate_parts import dimensions_of, shaft_notes
from synth.hopper.leg_as_drawn import LegAsDrawn, equivalent_rate, leg_as_drawn, links_differ
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg
from synth.jump.jump_models import MODELS
from synth.jump.jump_runs import simulate

LEG = HopperLeg()


def energy(leg: HopperLeg, rates: dict[str, float]) -> float:
    """Taken by two hips, two knees and the foot between crouch and extension, joint by joint."""
    total, rest = 0.0, leg.flexures
    for sign, upper in ((1.0, leg.extended), (-1.0, leg.start)):
        lower = leg.lower_angle(upper)
        total += sign * rates["hip"] * (upper - rest.hip_rest) ** 2
        total += sign * rates["knee"] * (upper + lower - rest.knee_rest) ** 2
        total += sign * 0.5 * rates["foot"] * (2 * lower - rest.foot_rest) ** 2
    return total


def test_equal_hinges_have_their_own_rate() -> None:
    assert equivalent_rate(LEG, dict.fromkeys(("hip", "knee", "foot"), 0.013)) == pytest.approx(0.013)


def test_the_energy_of_the_stroke_is_kept() -> None:
    rates = {"hip": 0.0034, "knee": 0.0025, "foot": 0.0022}
    one = equivalent_rate(LEG, rates)
    assert energy(LEG, dict.fromkeys(rates, one)) == pytest.approx(energy(LEG, rates), rel=1e-12)


def test_springs_without_net_work_have_their_mean_rate() -> None:
    """Rests in the middle of every joint's stroke: as much is given as taken."""
    a, b = LEG.start, LEG.extended
    low, high = LEG.lower_angle(a), LEG.lower_angle(b)
    rests = replace(LEG.flexures, hip_rest=(a + b) / 2, knee_rest=(a + b + low + high) / 2, foot_rest=low + high)
    leg = replace(LEG, flexures=rests)
    assert equivalent_rate(leg, {"hip": 0.01, "knee": 0.02, "foot": 0.03}) == pytest.approx(0.018)


def test_flexures_matter_to_the_jump() -> None:
    """A leg whose flexures take energy from the stroke clears another height than one without."""
    leg = replace(LEG, length=0.1)
    contact, drive = Contact(), motor(75)
    plain = replace(leg, flexures=Flexures(rate=0.0))
    some = replace(leg, flexures=replace(leg.flexures, rate=0.01))
    clear = [one.clearance for one in simulate([(plain, drive), (some, drive)], contact, MODELS["A"])]
    assert all(math.isfinite(value) for value in clear)
    assert clear[0] != pytest.approx(clear[1], rel=1e-3)


def test_the_note_and_the_json_have_the_same_heights() -> None:
    links, own = (0.0464, 0.0633), (0.025, 0.747)
    rates = {"hip": 0.003, "knee": 0.0025, "foot": 0.002}
    found = LegAsDrawn(rates, 0.005, True, links, own, 0.0462, 0.033, 0.036, 0.042, "full")
    assert "clears 3.3 cm instead of 4.2 cm by model full; with its flexures alone as drawn 3.6 cm" in found.note
    assert (
        "46.4 g/m and E I = 0.0633 N*m^2 instead of 25 g/m and E I = 0.747 N*m^2; the leg weighs 46.2 g" in found.note
    )
    written = found.as_json()
    assert written["clearance"]["value"] == pytest.approx(3.3)
    assert written["clearance_flexures_alone"]["value"] == pytest.approx(3.6)
    assert written["equivalent_rate"] == {"value": 0.005, "unit": "N*m/rad"}
    stiff = replace(found, softer=False)
    assert "flexures" not in stiff.note
    assert "equivalent_rate" not in stiff.as_json()


DRAWN = """\
kind: hopper-design
motors: {use: ["N20 HP 6V 75:1"]}
lengths: {least: 50 mm, most: 50 mm, step: 10 mm}
"""


def test_the_forecast_as_drawn_has_the_drawn_links_mass_and_stiffness(tmp_path: Path) -> None:
    """Links of 25 g/m were simulated and 46 g/m drawn; the forecast is that of a project that simulates the strip."""
    (tmp_path / "a.yaml").write_text(DRAWN)
    study = synth.hopper(tmp_path / "a.yaml").study
    laminate, rate = study.best_leg.laminate, study.best_leg.flexures.rate
    drawn = leg_as_drawn(study, {"hip": 2.0, "knee": 2.0, "foot": 2.0}, 1.0)
    assert drawn is not None
    assert drawn.links == pytest.approx((1820 * 0.015 * 0.0017, laminate.strip_bending_stiffness))
    assert drawn.total_mass - study.best_leg.total_mass(study.best_motor) == pytest.approx((0.04641 - 0.025) * 0.2)
    (tmp_path / "a.yaml").write_text(f"{DRAWN}laminate: {{links: strip}}\nflexures: {{rate: {rate / 2} N*m/rad}}\n")
    strip = synth.hopper(tmp_path / "a.yaml").study
    written = strip.sweep.values["clearance"][strip.best]
    assert drawn.clearance == pytest.approx(written, abs=2e-4)
    assert drawn.clearance < drawn.flexures_alone - 1e-3
    assert not links_differ(strip.best_leg.laminate)
    assert leg_as_drawn(strip, dict.fromkeys(drawn.rates, 1.0), 1.0) is None
    assert leg_as_drawn(study, dict.fromkeys(drawn.rates, 1.0), 1.0) is not None


@pytest.mark.parametrize(
    ("motor", "line", "bore", "said"),
    [("20D 6V 62.5*", "", 3.0, "does not state the output shaft of 20D 6V 6"), ("N20 HP 6V 75:1", "", 3.0, ""),
     ("N20 HP 6V 75:1", "parts: {motor_shaft: 4 mm}\n", 4.0, "the catalogue states a shaft of 3 mm"),
     pytest.param("25D HP 6V 20.4*", "", 4.0, "", marks=pytest.mark.slow),
     pytest.param("20D 6V 62.5*", "parts: {motor_shaft: 4 mm}\n", 4.0, "", marks=pytest.mark.slow)],
)  # fmt: skip
def test_the_hub_s_bore_is_that_of_the_motor_s_shaft(
    motor: str, line: str, bore: float, said: str, tmp_path: Path
) -> None:
    (tmp_path / "a.yaml").write_text(
        f'kind: hopper-design\nmodel: A\nmotors: {{use: ["{motor}"], supply: 12 V}}\nleg: {{hip_spacing: 60 mm}}\n'
        f"lengths: {{least: 100 mm, most: 100 mm, step: 10 mm}}\n{line}"
    )
    study = synth.hopper(tmp_path / "a.yaml").study
    assert study.best is not None
    row = study.rows[int(study.sweep.motor[study.best])]
    row = replace(row, size=row.size.replace("shaft", "shaft 9 mm"))  # is not read for it
    made = dimensions_of(study, row)
    assert not isinstance(made, str)
    assert made.shaft == pytest.approx(bore)
    notes = shaft_notes(study, row)
    assert (said in notes[0]) if said else notes == []
