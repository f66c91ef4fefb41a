"""A leg made in code passes the checks of its file, and what is written can be read again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf, nan, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import synth
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import in_code

EXAMPLES = Path(synth.__file__).parent / "examples"
TIME = np.linspace(0.0, 1.0, 101)
TRIAL = synth.Trial("a", TIME, radians(100) + 0.3 * np.cos(9.0 * TIME)[:, None])


def link(**changed: Any) -> synth.Link:
    return synth.Link(**{"length": 0.22, "mass": 0.207, "com": 0.075, "inertia": 1.0885e-3, **changed})


def joint(**changed: Any) -> synth.Joint:
    usual = {
        "name": "knee", "zero": radians(180), "sign": 1, "link": link(), "spring": synth.Spring(1.7, radians(108)),
        "damper": synth.Damper(rate=0.02),
    }  # fmt: skip
    return synth.Joint(**{**usual, **changed})


def of(**changed: Any) -> synth.Leg:
    """A leg of one joint with these attributes."""
    return synth.Leg("shank", (joint(**changed),))


def damped(speed: Any, torque: Any) -> synth.Leg:
    return of(damper=synth.Damper(curve=synth.DamperCurve(speed, torque)))


MOTOR = GearedMotor(2.0, 0.05, 30.0)
RUBS = {"coulomb_friction": {"torque": 0.05}}
BAD = [
    (of(link=link(length=-1.0)), "joints.knee.link.length: -1 m is not allowed: it must be more than 0"),
    (of(link=link(length=0.01)), "joints.knee.link.com: 0.075 m is 7.5 lengths of the link away"),
    (of(link=link(inertia=-1e-3)), r"link.inertia: -0.001 kg\*m\^2 is not allowed"),
    (of(link=link(mass=nan)), "link.mass: nan is not allowed: in code this is a number in kg"),
    (of(link=link(mass="207 g")), 'link.mass: "207 g" is not allowed: in code this is a number in kg'),
    (of(link=link(mass=None)), "link.mass: None is not allowed"),
    (of(link=link(includes="all")), 'link.includes: "all" is not allowed; allowed here: none, joint'),
    (of(link={"length": 0.2}), "joints.knee.link: .* is no Link: write synth.Link"),
    (of(spring=1.7), "joints.knee.spring: 1.7 is no Spring: write synth.Spring"),
    (of(spring=synth.Spring(-1.0, 1.0)), "spring.rate: -1 N.m/rad is not allowed: it must be at least 0"),
    (of(spring=synth.Spring(1.0, 108.0)), "free_angle: 108 rad is not allowed: it can be at most 720 deg; .*radians"),
    (of(zero=180.0), "joints.knee.zero: 180 rad is not allowed: it can be at most 720 deg; in code angles are in rad"),
    (of(sign=2), "joints.knee.sign: 2 is not allowed: write"),
    (of(range=(2.0, 1.0)), "joints.knee.range: the range must go from the smaller"),
    (of(range=(2.0,)), "joints.knee.range: .* has 1 items"),
    (of(range=1.0), "joints.knee.range: 1.0 is not allowed: in code this is a tuple"),
    (of(range=(1.0, "2 rad")), 'joints.knee.range.2.: "2 rad" is not allowed: in code this is a number in rad'),
    (of(armature=-1e-5), "joints.knee.armature: -1e-05 kg"),
    (of(armature=None), "joints.knee.armature: None is not allowed"),
    (of(name="all"), '"all" cannot be a joint\'s name'),
    (of(damper=synth.Damper()), 'joints.knee.damper: needs "rate"'),
    (of(damper=synth.Damper(rate=-0.1)), "joints.knee.damper.rate: -0.1"),
    (of(damper=synth.Damper(part="x")), 'joints.knee.damper.part: .*write its rate or curve beside it'),
    (damped((1.0, 0.5), (0.1, 0.2)), "joints.knee.damper.curve: point 2: speeds must increase"),
    (damped((1.0, 2.0), (0.1, -0.2)), "damper.curve: point 2: torques must not be negative"),
    (damped((0.0, 2.0), (0.0, 0.2)), "damper.curve: leave the point at speed 0 out"),
    (damped((1.0, 2.0), (0.1,)), "damper.curve: has 2 speeds and 1 torques"),
    (damped((), ()), "damper.curve: has no point"),
    (damped((1.0, nan), (0.1, 0.2)), "damper.curve.speed: .* is not allowed"),
    (of(effects=[RUBS]), r"joints.knee.effects: .* in code this is a mapping, \{"),
    (of(effects=None), "joints.knee.effects: None is not allowed"),
    (of(effects={"coulomb_frictio": {"torque": 0.05}}), r"joint can hold \(one of your own: .*; did you mean coulomb"),
    (of(effects={"coulomb_friction": {"torqe": 0.05}}), '"torqe" is no parameter of coulomb_friction; did you mean'),
    (of(effects={"coulomb_friction": {"torque": -0.05}}), "coulomb_friction.torque: -0.05 N.m is not allowed"),
    (of(effects={"coulomb_friction": {"torque": "0.05 N*m"}}), "coulomb_friction.torque: .* a number in N.m"),
    (of(drive=Servo(-1.0)), "drive: gain: -1 N.m/rad is not allowed"),
    (of(drive=Servo(nan)), "drive.gain: nan is not allowed"),
    (of(drive=Servo(1.0, delay=inf)), "drive.delay: inf is not allowed"),
    (of(drive=TorqueDrive(replace(MOTOR, efficiency=1.5))), "drive.motor.efficiency: 1.5 is not allowed"),
    (of(drive=TorqueDrive("a motor")), "drive.motor: 'a motor' is no GearedMotor"),
    (of(drive=MOTOR), "joints.knee.drive: .* is no Servo or TorqueDrive"),
    (synth.Leg("", (joint(),)), 'name: "" is empty'),
    (synth.Leg("none", ()), "joints: .* has 0 items; at least 1"),
    (synth.Leg("seven", tuple(joint(name=f"j{k}") for k in range(7))), "no more than 6"),
    (synth.Leg("bare", joint()), "joints: .* in code this is a tuple"),
    (synth.Leg("twice", (joint(), joint())), '"knee" is used twice; rename one'),
    (synth.Leg("upwards", (joint(),), gravity=-9.81), r"gravity: -9.81 m/s\^2 is not allowed: it must be at least 0"),
    (synth.Leg("words", (joint(),), gravity="9.81 m/s^2"), 'gravity: "9.81 m/s.2" is not allowed'),
    (synth.Leg("tilted", (joint(),), tilt=1500.0), "tilt: 1500 rad is not allowed: it can be at most 720 deg"),
    (synth.Leg("moved", (joint(),), effects=RUBS), '"coulomb_friction" is no effect that a base can hold'),
]  # fmt: skip


@pytest.mark.parametrize(("leg", "said"), BAD, ids=[said[:40] for _, said in BAD])
def test_what_a_file_may_not_say_is_refused(leg: synth.Leg, said: str, tmp_path: Path) -> None:
    ways: list[Callable[[], object]] = [
        partial(synth.fit, leg, [TRIAL]),
        partial(synth.gap, leg, [TRIAL]),
        partial(synth.read_trials, "a.csv", leg, folder=tmp_path),
        partial(synth.compare, leg, TRIAL),
        partial(synth.write_leg, leg, tmp_path / "x.leg.yaml"),
    ]
    for way in ways:
        with pytest.raises(synth.UserError, match=f"^a leg made in code: .*{said}"):
            way()
    assert list(tmp_path.iterdir()) == []


def test_every_mistake_is_told_at_once() -> None:
    with pytest.raises(synth.UserError) as caught:
        synth.fit(
            synth.Leg("x", (joint(sign=0, link=link(mass=-1.0)), joint(name="hip", zero=90.0)), gravity=-1.0), [TRIAL]
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"gravity", "joints.knee.sign", "joints.knee.link.mass", "joints.hip.zero"}


DRIVES = [
    Servo(20.0, 0.5, delay=0.01, torque_limit=3.0),
    Servo(20.0, 0.5, integral_gain=60.0, integral_limit=1.0),
    Servo(2.0, motor=MOTOR, supply=12.0, control_period=1e-3, duty_steps=255.0),
    Servo(0.0, motor=replace(MOTOR, inductance=1e-3), open_duty=1.0),
    TorqueDrive(replace(MOTOR, resistance=inf)),
    TorqueDrive(),
    None,
]


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: type(drive).__name__)
def test_a_good_leg_is_written_and_read_again(drive: Any, tmp_path: Path) -> None:
    curve = synth.DamperCurve((1.0, 4.0), (0.5, 0.8))
    own = {"drive": drive, "effects": RUBS, "range": (np.float64(1.0), 2.6), "sign": np.int64(-1)}
    hip = joint(name="hip", damper=synth.Damper(curve=curve), spring=None, zero=0)
    made = synth.Leg("two", (joint(**own), hip), tilt=np.float32(0.1))
    synth.write_leg(made, tmp_path / "two.leg.yaml")
    read = synth.read_leg(tmp_path / "two.leg.yaml")
    assert read.joints[0].drive == drive
    assert read.joints[1].damper == made.joints[1].damper
    check_leg(read, in_code(tmp_path))


def test_legs_that_were_read_are_taken() -> None:
    files = sorted(EXAMPLES.rglob("*.leg.yaml"))
    assert len(files) >= 4
    for file in files:
        check_leg(synth.read_leg(file), in_code(file))


def test_a_leg_is_checked_in_an_altered_project() -> None:
    from synth.api.fitting import read_fit

    project = read_fit(EXAMPLES / "fit" / "fit.yaml")
    heavier = project.leg.with_joints(knee={"zero": 180.0})
    with pytest.raises(synth.UserError, match=r"fit\.yaml: joints\.knee\.zero: 180 rad is not allowed"):
        synth.fit(replace(project, leg=heavier))


def test_options_of_another_class_are_refused() -> None:
    for given in (synth.FitOptions(method="swarm"), {"laws": "linear"}):
        with pytest.raises(synth.UserError, match=r"is no FitSettings: write synth\.FitSettings"):
            synth.fit(of(), [TRIAL], given)  # type: ignore[arg-type]
    with pytest.raises(synth.UserError, match=r"tolerance\.mass: nan is not allowed: in code this is a share"):
        synth.fit(of(), [TRIAL], synth.FitSettings(tolerance=synth.Tolerance(mass=nan)))
    for function in (synth.fit, synth.gap):
        with pytest.raises(synth.UserError, match="5 is neither a project's file nor a leg"):
            function(5)  # type: ignore[operator]
