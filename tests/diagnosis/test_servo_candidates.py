"""Candidate causes of a servo-driven joint."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.swing.leg_model import Joint, Leg, Link

SERVO = Servo(gain=1.0, supply=7.4, motor=GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8))
LEG = Leg("arm", (Joint("arm", Link(0.12, 0.49, 0.1, 1e-4), drive=SERVO),))


def looked_for(supply: np.ndarray, length: float = 5.0) -> set[str]:
    ones = np.ones((len(supply), 1))
    signals = ServoSignals(np.arange(len(supply)) * 0.01, 0.0 * ones, supply[:, None], ones)
    recording = SimpleNamespace(known_torque=None, signals=signals, leg=None, free=[0])
    trial = SimpleNamespace(recording=recording, free=(0,), time=np.array([0.0, length]))
    return {candidate.effect.name for candidate in candidates(LEG, [trial], SimpleNamespace())}  # type: ignore[list-item, arg-type]


@pytest.mark.parametrize(("supply", "looked"), [(np.full(50, 7.4), True), (np.linspace(7.4, 7.1, 50), False)])
def test_source_resistance_is_a_candidate_only_for_an_unmeasured_supply(supply: np.ndarray, looked: bool) -> None:
    found = looked_for(supply)
    assert ("voltage_sag" in found) is looked
    assert {"gear_friction", "command_delay"} <= found


@pytest.mark.parametrize(("second", "shared"), [(7.4, [("shared_source_resistance", "base")]), (12.0, [])])
def test_servos_of_one_stated_supply_have_one_source_beside_the_leads_of_each(
    second: float, shared: list[tuple[str, str]]
) -> None:
    link, ones = Link(0.12, 0.49, 0.1, 1e-4), np.ones((50, 2))
    joints = [Joint(name, link, drive=replace(SERVO, supply=v)) for name, v in (("hip", 7.4), ("knee", second))]
    signals = ServoSignals(np.arange(50) * 0.01, 0.0 * ones, np.array([7.4, second]) * ones, ones)
    recording = SimpleNamespace(known_torque=None, signals=signals, leg=None, free=[0, 1])
    trial = SimpleNamespace(recording=recording, free=(0, 1), time=np.array([0.0, 5.0]))
    found = candidates(Leg("leg", tuple(joints)), [trial], SimpleNamespace())  # type: ignore[list-item, arg-type]
    wanted = [*shared, ("voltage_sag", "hip"), ("voltage_sag", "knee")]
    sagging = ("voltage_sag", "shared_source_resistance")
    assert sorted(each.key for each in found if each.effect.name in sagging) == sorted(wanted)


@pytest.mark.parametrize(("length", "looked"), [(5.0, False), (60.0, True)])
def test_a_warming_winding_is_a_candidate_only_in_logs_long_enough(length: float, looked: bool) -> None:
    assert ("winding_heating" in looked_for(np.full(50, 7.4), length)) is looked
