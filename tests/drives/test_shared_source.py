"""One source with a resistance that feeds the servos of two joints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals, fed_together
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg, Link

HIP = Servo(2.0, 0.02, supply=7.4, motor=GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8))
KNEE = Servo(3.0, 0.0, supply=7.4, motor=GearedMotor(5.0, 0.3 / 150.0, 150.0, 0.8, 4e-8))
LINKS = Link(0.12, 0.4, 0.1, 4e-4), Link(0.1, 0.2, 0.08, 2e-4)
TIMES = np.linspace(0.0, 1.5, 301)
COMMAND = np.column_stack([0.9 * np.sin(5.0 * TIMES), 0.7 * np.sin(8.0 * TIMES) + 0.2 * np.sin(3.0 * TIMES)])
OHMS = 1.2


def two(*servos: Servo, ohms: float = 0.0) -> Leg:
    each = zip(("hip", "knee"), LINKS, servos, strict=True)
    joints = tuple(Joint(name, link, drive=servo) for name, link, servo in each)
    return Leg("leg", joints, effects={"shared_source_resistance": {"resistance": ohms}} if ohms else {})


def told(n: int = 2) -> ServoSignals:
    wide = np.ones((len(TIMES), n))
    return ServoSignals(TIMES, COMMAND[:, :n], 7.4 * wide, wide)


def torques(servos: tuple[Servo, ...], ohms: float, q: Array, w: Array, command: Array) -> list[float]:
    """N m of each servo, with the voltage behind the source found by bisection; nothing is shared but data."""
    each = zip(servos, command, q, w, strict=True)
    duty = [min(max(s.gain * (c - x) - s.damping_gain * v, -1.0), 1.0) for s, c, x, v in each]

    def currents(volts: float) -> tuple[list[float], float]:
        """A in each winding, and in the source by the power that each half bridge takes."""
        found, power = [], 0.0
        for servo, d, v in zip(servos, duty, w, strict=True):
            motor = servo.motor
            assert motor is not None
            induced = motor.torque_constant * motor.gear_ratio * v
            amperes = (d * volts - induced) / motor.resistance
            amperes = min(max(amperes, -servo.current_limit), servo.current_limit)
            found.append(amperes)
            power += amperes * (amperes * motor.resistance + induced)
        return found, power / volts

    volts = brentq(lambda v: v - 7.4 + ohms * currents(v)[1], 2.0, 20.0, xtol=1e-13)
    amperes = currents(volts)[0]
    return [i * s.motor.torque_a_current for i, s in zip(amperes, servos, strict=True) if s.motor is not None]


def moved(servos: tuple[Servo, ...], ohms: float, heat: dict[str, float] | None = None) -> Array:
    """(m, 2) rad with scipy, the mass matrix written out for two links; ``heat`` warms the knee's winding."""
    (a, b), g = LINKS, 9.81
    rotor = [s.motor.reflected_inertia for s in servos if s.motor is not None]
    c, far = b.mass * a.length * b.com, b.inertia + b.mass * b.com**2

    def slope(t: float, x: Array) -> list[float]:
        q, w = x[:2], x[2:4]
        command = np.array([np.interp(t, TIMES, COMMAND[:, j]) for j in range(2)])
        drive = torques((servos[0], warmed(servos[1], x[4])), ohms, q, w, command)
        m11 = a.inertia + a.mass * a.com**2 + b.mass * a.length**2 + far + 2.0 * c * math.cos(q[1]) + rotor[0]
        m12, m22 = far + c * math.cos(q[1]), far + rotor[1]
        outer = b.mass * g * b.com * math.sin(q[0] + q[1])
        inner = (a.mass * a.com + b.mass * a.length) * g * math.sin(q[0])
        turning = c * math.sin(q[1])
        f0 = drive[0] - inner - outer + turning * (2.0 * w[0] * w[1] + w[1] ** 2)
        f1 = drive[1] - outer - turning * w[0] ** 2
        det = m11 * m22 - m12**2
        grown = 0.0
        if heat is not None:
            grown = (heat["rise"] * (drive[1] / heat["reference"]) ** 2 * (1.0 + x[4]) - x[4]) / heat["time"]
        return [w[0], w[1], (m22 * f0 - m12 * f1) / det, (m11 * f1 - m12 * f0) / det, grown]

    x, found = np.zeros(5), [np.zeros(2)]
    for k in range(len(TIMES) - 1):  # piecewise: the commands bend at their samples
        part = solve_ivp(slope, (TIMES[k], TIMES[k + 1]), x, "RK45", rtol=1e-9, atol=1e-11)
        x = part.y[:, -1]
        found.append(x[:2].copy())
    return np.array(found)


@pytest.mark.parametrize("limit", [math.inf, 0.7], ids=["free", "limited"])
def test_two_joints_share_one_drop_as_an_independent_simulation_has_it(limit: float) -> None:
    servos = replace(HIP, current_limit=limit), KNEE
    plain = simulate(two(*servos), [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-9)
    found = simulate(two(*servos, ohms=OHMS), [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-9)
    wanted = moved(servos, OHMS)
    assert float(np.abs(wanted - plain).max()) > 0.02
    np.testing.assert_allclose(found, wanted, atol=2e-6)


def warmed(servo: Servo, growth: float) -> Servo:
    """With a larger resistance of its winding, and its source as it is."""
    assert servo.motor is not None
    return replace(servo, motor=replace(servo.motor, resistance=servo.motor.resistance * (1.0 + growth)))


def test_a_winding_that_warms_draws_less_from_the_source() -> None:
    """The source stays cold; its drop was that of cold windings."""
    heat = {"rise": 1.0, "reference": 0.1, "time": 2.0}
    leg = two(HIP, KNEE, ohms=OHMS)
    knee = replace(leg.joints[1], effects={"winding_heating": heat})
    warm = replace(leg, joints=(leg.joints[0], knee))
    found, plain = (
        simulate(each, [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-9) for each in (warm, leg)
    )
    assert float(np.abs(found - plain).max()) > 0.02
    np.testing.assert_allclose(found, moved((HIP, KNEE), OHMS, heat), atol=2e-6)


def test_a_source_of_one_joint_is_the_same_shared_or_not() -> None:
    """With the other winding off: the closed form of ``unlimited_torque``."""
    alone = replace(HIP, source_resistance=OHMS)
    off = told()
    off.enabled[:, 1] = 0.0
    shared = simulate(two(HIP, KNEE, ohms=OHMS), [0.0, 0.0], [0.0, 0.0], TIMES, signals=off, tolerance=1e-9)
    own = simulate(two(alone, KNEE), [0.0, 0.0], [0.0, 0.0], TIMES, signals=off, tolerance=1e-9)
    np.testing.assert_allclose(shared, own, atol=1e-7)


def test_held_duties_share_the_drop_too() -> None:
    steps = [replace(servo, control_period=1e-4) for servo in (HIP, KNEE)]
    held = simulate(two(*steps, ohms=OHMS), [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-7)
    quick = simulate(two(HIP, KNEE, ohms=OHMS), [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-9)
    assert float(np.abs(held - quick).max()) < 1e-3


def test_a_lane_without_a_drop_beside_one_with_it_moves_as_alone() -> None:
    legs = LegLanes.of(two(HIP, KNEE), 2)
    legs.source[:] = 0.0, OHMS
    chain = compiled_chain(2)
    both = chain.run(chain.lanes(legs, Conditions()), TIMES, 1e-9, signals=told())
    plain = simulate(two(HIP, KNEE), [0.0, 0.0], [0.0, 0.0], TIMES, signals=told(), tolerance=1e-9)
    np.testing.assert_allclose(both[:, :, 0], plain, atol=1e-7)
    assert float(np.abs(both[:, :, 1] - plain).max()) > 0.02


def test_joints_of_one_stated_supply_have_one_source() -> None:
    other, known = replace(KNEE, supply=12.0), replace(KNEE, open_duty=1.0)
    assert fed_together([HIP, KNEE]) == [0, 1]
    assert fed_together([HIP, None, KNEE, other]) == [0, 2]
    assert fed_together([HIP, other]) == fed_together([HIP, known]) == fed_together([HIP]) == []
