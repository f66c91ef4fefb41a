"""A small sample of blind jumps, made by MuJoCo with other functional forms, through ``synth gap``."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blind import jump_cases
from blind.jump_cases import Asked, Sensors, draw_errors, record
from blind.jump_engine import JumpConditions, JumpTruth, jump
from blind.jumps import kind_of
from hopper.hoppers import catalogue, motor
from synth.cli import main
from synth.jump.hopper_leg import Contact, HopperLeg
from synth.jump.jump_models import MODELS, columns
from synth.jump.planar_jump import planar_record

BASE = Asked("base", 150, 0.12)
TRIALS = (
    BASE, replace(BASE, name="loaded", payload=0.01), replace(BASE, name="short", length=0.10),
    replace(BASE, name="check", length=0.13, held_out=True),
)  # fmt: skip
NOISE = {"upper link": math.radians(0.1), "ground force": 0.02, "current": 0.01, "supply": 0.01}


def diagnosed(folder: Path, effects: dict[str, float], seed: int) -> dict[str, Any]:
    """The diagnosis of a leg within its tolerances with these effects; currents are recorded too."""
    rng = np.random.default_rng(seed)
    errors, sensors = draw_errors(rng), Sensors(NOISE, extra=True)
    made = [(asked, record(asked, errors, effects, sensors, rng, catalogue())) for asked in TRIALS]
    jump_cases._write_trials(folder, made)
    assert main(["-q", "gap", str(folder / "gap.yaml"), "--out", str(folder / "out")]) == 0
    return json.loads((folder / "out" / "gap.json").read_text())  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("effects", "name", "least", "most"),
    [
        pytest.param({"joint_damping.damping": 6e-4}, "joint_damping", 3e-4, 9e-4, marks=pytest.mark.slow),
        pytest.param({"voltage_sag.resistance": 0.5}, "voltage_sag", 0.35, 0.65, marks=pytest.mark.slow),
        ({"gear_friction.torque": 5e-4}, "gear_friction", 3.5e-4, 6.5e-4),
    ],
)
def test_the_withheld_effect_is_named(
    effects: dict[str, float], name: str, least: float, most: float, tmp_path: Path
) -> None:
    found = diagnosed(tmp_path / "case", effects, 5)
    assert found["verdict"] == "effect"
    (cause,) = found["explanation"]
    assert cause["effect"] == name
    (value,) = cause["parameters"].values()
    assert least < value["value"] < most
    gap = found["gap"]
    assert gap["scored_on"] == ["trials/check.csv"]
    assert gap["shrink"]["value"] > 0.5
    assert gap["after"]["value"] < 0.2 * gap["as_designed"]["value"]
    assert gap["after"]["value"] < 1.6 * gap["noise_floor"]["value"]
    design = next(item for item in found["across"]["designs"] if not item["learnt_from"])
    assert abs(design["error"]["after"]["value"]) < 3.0
    assert design["error"]["as_designed"]["value"] > 15.0


def test_errors_within_tolerances_are_no_effect(tmp_path: Path) -> None:
    found = diagnosed(tmp_path / "case", {}, 6)
    assert found["verdict"] == "none"
    assert found["explanation"] == []
    assert found["probability_none"] > 0.3


def test_without_effects_the_two_engines_jump_alike() -> None:
    """The difference, about half a floor, is due to the reversal of gears and friction."""
    leg = HopperLeg()
    told = jump(JumpTruth(leg, motor(), Contact()), JumpConditions(motor().voltage, lean=math.radians(6.0)))
    made = columns(leg, motor(), Contact(), MODELS["full"], np.array([leg.length]))
    times = told["time"][told["time"] < 0.055]
    ours = planar_record(made, leg.body_inertia, Contact().slip_speed, math.radians(6.0), times, 1e-5)
    n = len(times)
    for name, channel, tolerance in (
        ("angle", "upper link", math.radians(0.5)), ("pitch", "pitch", math.radians(0.1)), ("current", "current", 0.1),
    ):  # fmt: skip
        np.testing.assert_allclose(ours[name], told[channel][:n], atol=tolerance)
    assert np.ptp(told["upper link"][:n]) > math.radians(15.0)


def test_every_effect_has_its_turn_among_the_cases() -> None:
    kinds = [kind_of(number) for number in range(24)]
    assert {effect for kind, effect in kinds if kind == "single"} == set(jump_cases.PLACES)
    assert {kind for kind, _ in kinds} == {"single", "two", "none", "unknown"}
