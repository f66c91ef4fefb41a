"""Drawn hinges of three rates: the jump is that of all three, and what is told of them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

import synth
from hopper.hoppers import motor
from synth.hopper.laminate_parts import dimensions_of, shaft_notes
from synth.hopper.leg_as_drawn import JOINTS, LegAsDrawn, leg_as_drawn, links_differ, with_hinges
from synth.hopper.study import Study
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, Laminate
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.outcomes import outcome_of

LEG, CONTACT = HopperLeg(length=0.05), Contact()
STRIP = Laminate(Laminate().strip_mass_per_length, Laminate().strip_bending_stiffness)
# Clearance (m) of that leg by the model full, with rates of hip, knee and foot as factors of its own, by an integration
# of its own: Lagrange's equations from the Jacobians of all bodies, LSODA at 1e-8.
INTEGRATED = (((1.0, 1.0, 1.0), 0.04208), ((1.0, 1.0, 0.5), 0.05440), ((1.0, 0.5, 0.5), 0.03102))


@pytest.mark.parametrize(("factors", "wanted"), INTEGRATED)
def test_hinges_of_three_rates_jump_as_high_as_by_another_integration(
    factors: tuple[float, float, float], wanted: float
) -> None:
    """One rate of equal energy stood for them: -0.16 N*m/rad with a softer foot, 0.11 with softer knees too."""
    rates = {name: factor * LEG.flexures.rate for name, factor in zip(JOINTS, factors, strict=True)}
    jump = with_hinges(lane(LEG, motor(75), CONTACT, MODELS["full"]), LEG.bending, rates)
    found = outcome_of(compiled_jump(LEG.bending).run(jump[:, None])[:, 0])
    assert found.clearance == pytest.approx(wanted, abs=2e-4)


def test_a_single_softer_joint_is_told() -> None:
    """Softer knees raised the rate of equal energy, so that nothing was told."""
    study = SimpleNamespace(
        best_leg=replace(LEG, laminate=STRIP), best_motor=motor(75), project=SimpleNamespace(model="full"),
        sweep=SimpleNamespace(problem=SimpleNamespace(contact=CONTACT)),
    )  # fmt: skip
    found = leg_as_drawn(cast("Study", study), {"hip": 1.0, "knee": 2.0, "foot": 1.0}, 1.0)
    assert found is not None
    assert found.softer
    assert "flexures (hip 0.0229, knee 0.0115, foot 0.0229 N*m/rad)" in found.note
    assert abs(found.flexures_alone - found.simulated) > 1e-3


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
    found = LegAsDrawn(rates, True, links, own, 0.0462, 0.033, 0.036, 0.042, "full")
    assert "clears 3.3 cm instead of 4.2 cm by model full; with its flexures alone as drawn 3.6 cm" in found.note
    assert (
        "46.4 g/m and E I = 0.0633 N*m^2 instead of 25 g/m and E I = 0.747 N*m^2; the leg weighs 46.2 g" in found.note
    )
    written = found.as_json()
    assert written["clearance"]["value"] == pytest.approx(3.3)
    assert written["clearance_flexures_alone"]["value"] == pytest.approx(3.6)
    assert written["rate_for_all_joints"] == {"value": 0.002, "unit": "N*m/rad"}
    stiff = replace(found, softer=False)
    assert "flexures" not in stiff.note
    assert "rate_for_all_joints" not in stiff.as_json()


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
