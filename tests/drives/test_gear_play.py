"""Play of a drive's gear against scipy: the same flanks, and rigid ones from blow to blow."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from blind.servo_engine import COLUMNS, Rig, follow
from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.gap_project import read_gap_project
from synth.files.leg_file import write_leg
from synth.swing.chain import simulate
from synth.swing.effects.gear_play import LEAST_ROTOR
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg, Link, Spring

LINK = Link(0.12, 0.49, 0.1, 1e-4)
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
SERVO = Servo(2.3, 0.01, 0.0, 0.01, current_limit=1.0, supply=7.4, duty_limit=0.8, motor=MOTOR)
TIMES = np.linspace(0.0, 2.0, 401)  # s, of the angles
TOLD = np.arange(0.0, 2.0, 0.02)  # s, of the commands
COMMAND = np.where(TOLD < 1.2, 0.8 * np.sin(4.4 * TOLD) + 0.2 * np.sin(9.0 * TOLD), np.sign(np.sin(12.0 * TOLD)))
PLAY, CONTACT, DAMPING = math.radians(2.0), 0.01, 1.5
ROTOR, ABOUT_JOINT = MOTOR.reflected_inertia, LINK.inertia + LINK.mass * LINK.com**2
STIFFNESS = (math.pi / CONTACT) ** 2 / (1.0 / ROTOR + 1.0 / ABOUT_JOINT)
PLACES = [(1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]  # where the recorded angle and the controller's are read


def leg(read: float, controlled: float) -> Leg:
    play = {"play": PLAY, "contact": CONTACT, "damping": DAMPING}
    play |= {"read_beyond": read, "controlled_beyond": controlled}
    return Leg("arm", (Joint("arm", LINK, drive=SERVO, effects={"gear_play": play}),))


def signals() -> ServoSignals:
    ones = np.ones((len(TOLD), 1))
    return ServoSignals(TOLD, COMMAND[:, None], 7.4 * ones, ones, (0,))


def acting(x: Array, controlled: float, told: float) -> tuple[float, float]:
    """Torques on rotor and link, of state (rotor, link, their rates), without that between them."""
    seen, rate = (x[1], x[3]) if controlled else (x[0], x[2])
    beyond = told - seen
    beyond -= min(max(beyond, -SERVO.dead_band), SERVO.dead_band)
    duty = min(max(SERVO.gain * beyond - SERVO.damping_gain * rate, -0.8), 0.8)
    strength, back_emf, limit = SERVO.numbers[5:8]  # its back-EMF is by the rotor's rate
    driven = min(max(strength * duty * 7.4 - back_emf * x[2], -limit), limit)
    return driven, -LINK.mass * 9.81 * LINK.com * math.sin(x[1])


def elastic(read: float, controlled: float) -> Array:
    """(m,) rad: rotor and link with the effect's flanks, restarted at each command."""
    start = simulate(leg(read, controlled), [0.3], [0.0], np.array([0.0, 1e-9]), signals=signals())
    assert start[0, 0] == pytest.approx(0.3, abs=1e-12)  # what the encoder reads
    weight = -LINK.mass * 9.81 * LINK.com * math.sin(0.3)
    within = -PLAY / 2 + weight / STIFFNESS
    x = np.array([0.3 - within, 0.3, 0.0, 0.0] if read else [0.3, 0.3 + within, 0.0, 0.0])
    found = np.full(len(TIMES), np.nan)
    for (begin, told), (end, _) in pairwise([*zip(TOLD, COMMAND, strict=True), (2.0, 0.0)]):

        def slope(t: float, x: Array, told: float = float(told)) -> list[float]:
            driven, weight = acting(x, controlled, told)
            within, closing = x[1] - x[0], x[3] - x[2]
            deep, side = abs(within) - PLAY / 2, math.copysign(1.0, within)
            push = STIFFNESS * deep * max(1.0 + DAMPING * side * closing, 0.0) if deep > 0.0 else 0.0
            return [x[2], x[3], (driven + side * push) / ROTOR, (weight - side * push) / ABOUT_JOINT]

        part = solve_ivp(slope, (begin, end), x, "DOP853", rtol=1e-10, atol=1e-12, max_step=2e-4, dense_output=True)
        first, last = np.searchsorted(TIMES, [begin - 1e-12, end + 1e-12])
        found[first:last] = part.sol(TIMES[first:last])[1 if read else 0]
        x = part.y[:, -1]
    return found


@pytest.mark.parametrize(("read", "controlled"), PLACES)
def test_play_of_a_servo_against_scipy(read: float, controlled: float) -> None:
    assert ROTOR > LEAST_ROTOR * ABOUT_JOINT  # so it is not made heavier
    ours = simulate(leg(read, controlled), [0.3], [0.0], TIMES, signals=signals())[:, 0]
    theirs = elastic(read, controlled)
    assert np.abs(ours - theirs).max() < 2e-5


RIGID = Rig(
    np.array([[*(LINK.length, LINK.mass, LINK.com, LINK.inertia), 2.3, 0.0, 1.0, 0.4, 3.0, 1e9, 0.0, 0.0, 4e-3]
              + [0.0, 0.0, 1.0, 1.0] + [0.0] * (len(COLUMNS) - 17)]),
    0.0,
)  # fmt: skip
LOGGED = np.arange(0.0, 3.0, 0.005)  # s


def logged(play: float, read: float, controlled: float, rising: float) -> tuple[Array, Array]:
    """Command and angle (m, 1) rad of the other engine, with dry friction: two sines about 0.3 rad, from rest."""
    command = 0.3 + 0.6 * np.sin(rising * LOGGED) + 0.2 * np.sin(2.6 * rising * LOGGED)
    rig = RIGID.changed(0, play=play, read_beyond=read, controlled_beyond=controlled, dry=0.02)
    return command[:, None], follow(rig, LOGGED, command[:, None], 7.4)


def designed(effects: dict[str, dict[str, float]]) -> Leg:
    motor = GearedMotor(3.0, 0.4, 1.0, 1.0, 0.0)
    servo = Servo(2.3, 0.0, 0.0, 0.0, supply=7.4, motor=motor)
    return Leg("arm", (Joint("arm", LINK, drive=servo, armature=4e-3, effects=effects),))


@pytest.mark.parametrize(("read", "controlled"), PLACES)
def test_soft_flanks_act_as_rigid_ones(read: float, controlled: float) -> None:
    """As soft as the diagnosis has them: less than a tenth of the play's effect is left against rigid bodies."""
    play, on = math.radians(1.5), np.ones((len(LOGGED), 1))
    dry = {"coulomb_friction": {"torque": 0.02}}
    soft = {"play": play, "contact": 0.005, "damping": 5.0, "read_beyond": read, "controlled_beyond": controlled}
    for rising in (4.0, 9.0):
        command, theirs = logged(play, read, controlled, rising)
        given = ServoSignals(LOGGED, command, 7.4 * on, on, (0,))
        ours, without = (
            simulate(designed(effects), command[0], [0.0], LOGGED, signals=given)
            for effects in (dry | {"gear_play": soft}, dry)
        )
        left, whole = (float(np.sqrt(np.mean((each - theirs) ** 2))) for each in (ours, without))
        assert left < 0.1 * whole


def project(folder: Path, read: float, controlled: float) -> Path:
    rng, entries = np.random.default_rng(5), []
    for k, rising in enumerate((3.0, 5.0, 8.0, 6.0)):
        command, angle = logged(math.radians(1.2), read, controlled, rising)
        told = np.degrees(np.column_stack([angle + 1e-4 * rng.standard_normal(angle.shape), command]))
        header = "time [s],arm [deg],arm command [deg]"
        np.savetxt(folder / f"{k}.csv", np.column_stack([LOGGED, told]), "%.6g", ",", header=header, comments="")
        entries.append(f"  - {{file: {k}.csv, held_out: {str(k == 3).lower()}}}")
    write_leg(designed({}), folder / "arm.leg.yaml")
    (folder / "gap.yaml").write_text("\n".join(["kind: gap", "leg: arm.leg.yaml", "trials:", *entries]) + "\n")
    return folder / "gap.yaml"


@pytest.mark.parametrize(
    ("read", "controlled"), [PLACES[0], *(pytest.param(*place, marks=pytest.mark.slow) for place in PLACES[1:])]
)
def test_play_is_named_with_its_size_beside_friction(tmp_path: Path, read: float, controlled: float) -> None:
    """Recorded by the other engine; the leg file has neither."""
    given = read_gap_project(project(tmp_path, read, controlled))
    found = diagnose(given.leg, given.trials, given.tolerance)
    assert found.verdict == "effect"
    causes = {cause.effect: cause.parameters for cause in found.explanation}
    assert causes.keys() == {"gear_play", "coulomb_friction"}
    play = causes["gear_play"]
    assert play["play"].value == pytest.approx(math.radians(1.2), rel=0.05)
    assert (play["read_beyond"].value, play["controlled_beyond"].value) == (read, controlled)
    assert f"angle recorded {'behind' if read else 'before'} the play" in found.sentence
    assert causes["coulomb_friction"]["torque"].value == pytest.approx(0.02, rel=0.05)
    assert found.after.value < 0.1 * found.before.value


@pytest.mark.parametrize("read", [1.0, 0.0])
def test_a_held_leg_is_read_at_its_angles_beside_a_moving_base(read: float) -> None:
    """The base's own turn is not taken for that within the play."""
    arm = leg(read, read).joints[0]
    two = Leg("two", (arm, replace(arm, name="far")), effects={"base_compliance": {"rocking_stiffness": 50.0}})
    two = two.with_joints(far={"effects": {}, "spring": Spring(1.0, 0.2)}, arm={"spring": Spring(2.0, -0.4)})
    rotation = np.array([[0.3], [-0.5]])
    legs, held = LegLanes.held(two, rotation)
    assert legs.as_read(held[None])[0] == pytest.approx(rotation, abs=1e-12)


@pytest.mark.slow  # two minutes each: flanks this short take short steps, and longer ones leave a second cause
@pytest.mark.parametrize(("read", "controlled"), PLACES)
def test_stated_play_is_simulated_and_friction_is_found_beside_it(
    tmp_path: Path, read: float, controlled: float
) -> None:
    """The other engine's rigid flanks, stated as soft ones: what they differ by is no second cause."""
    given = read_gap_project(project(tmp_path, read, controlled))
    play = {"play": math.radians(1.2), "contact": 0.005, "damping": 5.0}
    stated = designed({"gear_play": {**play, "read_beyond": read, "controlled_beyond": controlled}})
    found = diagnose(stated, given.trials, given.tolerance)
    assert [(cause.effect, cause.joint) for cause in found.explanation] == [("coulomb_friction", "arm")]
    assert found.explanation[0].parameters["torque"].value == pytest.approx(0.02, rel=0.05)
    assert found.after.value < 0.1 * found.before.value


@pytest.mark.parametrize(("read", "controlled"), PLACES)
def test_play_beside_a_link_that_bends(read: float, controlled: float) -> None:
    """The rotor is parted from what is left of the link at the joint: with a stiff link as with a rigid one."""
    rigid = leg(read, controlled)
    alone = simulate(rigid, [COMMAND[0]], [0.0], TIMES, tolerance=1e-7, signals=signals())
    away = []
    for stiffness in (1e4, 5.0):
        effects = {**rigid.joints[0].effects, "link_flexibility": {"stiffness": stiffness}}
        bending = rigid.with_joints(arm={"effects": effects})
        motion = simulate(bending, [COMMAND[0]], [0.0], TIMES, tolerance=1e-7, signals=signals())
        away.append(float(np.sqrt(np.mean((motion - alone) ** 2))))
    assert away[0] < math.radians(0.05)
    assert away[1] > math.radians(0.5)
