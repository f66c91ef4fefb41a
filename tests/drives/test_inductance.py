"""A winding's inductance to first order against its current integrated, on a stiff small servo with hard steps."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

MASS, LENGTH, ROTOR = 0.49, 0.1, 1.8e-3  # of the XL330 on its bench, at its stiffest gain
MOTOR = GearedMotor(3.4, 0.36, rotor_inertia=ROTOR)
SERVO = Servo(2.3, supply=7.4, motor=MOTOR)
SIZE, STEP = 0.7, 5e-5  # rad and s
FIRST = 0.25  # s, of the first step
TIMES = np.arange(0.0, 2.0, 0.005)


def command(t: float) -> float:
    """From rest, steps from side to side, twice a second."""
    return 0.0 if t < FIRST else SIZE if (t - FIRST) % 1.0 < 0.5 else -SIZE


def integrated(lag: float, servo: Servo = SERVO) -> np.ndarray:
    """(m,) rad: the winding's current as a state, exact over each short step."""
    q = w = torque = 0.0
    found = []
    per = round((TIMES[1] - TIMES[0]) / STEP)
    for k in range(len(TIMES) * per):
        if k % per == 0:
            found.append(q)
        duty = max(-1.0, min(1.0, servo.gain * (command(k * STEP) - q) - servo.damping_gain * w))
        steady = MOTOR.strength * duty * servo.supply - 0.36**2 / 3.4 * w
        torque += (1.0 - math.exp(-STEP / lag)) * (steady - torque)
        inertia = MASS * LENGTH**2 + 1e-4 + ROTOR
        w += STEP * (torque - MASS * 9.81 * LENGTH * math.sin(q)) / inertia
        q += STEP * w
    return np.array(found)


def simulated(lag: float, driven: Servo = SERVO) -> np.ndarray:
    servo = replace(driven, motor=replace(MOTOR, inductance=lag * MOTOR.resistance))
    leg = Leg("arm", (Joint("arm", Link(LENGTH, MASS, LENGTH, 1e-4), drive=servo),))
    jumps = np.arange(FIRST, 2.0, 0.5)
    time = np.unique(np.concatenate([TIMES, jumps, jumps - 1e-7]))
    told = np.array([[command(t + 1e-9)] for t in time])
    wide = np.ones((len(time), 1))
    signals = ServoSignals(time, told, 7.4 * wide, wide)
    return np.asarray(simulate(leg, [0.0], [0.0], TIMES, signals=signals)[:, 0])


@pytest.mark.parametrize(("lag", "damping", "within"), [(1e-3, 0.0, 0.05), (2e-3, 0.0, 0.1), (2e-3, 0.15, 0.2)])
def test_to_first_order_the_winding_is_late(lag: float, damping: float, within: float) -> None:
    """With a damping gain too, whose duty is at its limit for a ninth of the time."""
    servo = replace(SERVO, damping_gain=damping)
    truth = integrated(lag, servo)

    def off(found: np.ndarray) -> float:
        return float(np.degrees(np.sqrt(np.mean((found - truth) ** 2))))

    assert off(simulated(lag, servo)) < within
    assert off(simulated(0.0, servo)) > (1.0 if damping else 10.0) * within


def test_without_a_stated_rotor_the_lag_lightens_the_link() -> None:
    """The same total inertia stated as the link's or as the rotor's moves alike."""
    motor = replace(MOTOR, inductance=1e-3 * MOTOR.resistance)
    wave = np.sin(9.0 * TIMES)[:, None]
    signals = ServoSignals(TIMES, wave, 7.4 + 0.0 * wave, 1.0 + 0.0 * wave)

    def moved(link: float, rotor: float) -> np.ndarray:
        servo = replace(SERVO, motor=replace(motor, rotor_inertia=rotor))
        leg = Leg("arm", (Joint("arm", Link(LENGTH, MASS, LENGTH, link), drive=servo),))
        return np.asarray(simulate(leg, [0.0], [0.0], TIMES, signals=signals, tolerance=1e-8))

    assert motor.lag * motor.short_circuit_damping > 3e-5
    np.testing.assert_allclose(moved(3e-4, 0.0), moved(1e-4, 2e-4), atol=5e-6)


def test_it_is_read_written_and_limited(tmp_path: Path) -> None:
    text = "kind: leg\nname: arm\njoints:\n  - name: arm\n    zero: 0 deg\n    sign: +1\n"
    text += "    link: {length: 0.1 m, mass: 0.5 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}\n"
    text += "    drive: {kind: servo, gain: 2 1/rad, supply: 7.4 V,\n"
    text += "      motor: {torque_constant: 0.36 N*m/A, resistance: 3.4 ohm, inductance: 3.4 mH}}\n"
    path = tmp_path / "arm.leg.yaml"
    path.write_text(text)
    drive = read_leg(path).joints[0].drive
    assert isinstance(drive, Servo)
    assert drive.motor is not None
    assert drive.motor.lag == pytest.approx(1e-3)
    write_leg(read_leg(path), tmp_path / "again.leg.yaml")
    assert read_leg(tmp_path / "again.leg.yaml").joints[0].drive == drive
    path.write_text(text.replace("3.4 mH", "3.4 H"))
    with pytest.raises(UserError, match=r"inductance over resistance is 1e\+03 ms; windings are simulated up to 2 ms"):
        read_leg(path)
