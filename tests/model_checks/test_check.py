"""``synth check``: its yardsticks are right by themselves, a right model holds, and a wrong one fails."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from math import exp, pi, radians, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from leg_energy import energy
from synth.cli import main
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo
from synth.files.leg_file import write_leg
from synth.model_checks import jumping, swinging
from synth.model_checks.checked import ModelCheck
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring
from synth.swing.mechanics import coefficients, mass_matrix

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"


def leg(curve: bool = False, **more: Any) -> Leg:
    """Two unequal links, tilted, one joint counted clockwise and with an armature."""
    damper = Damper(curve=DamperCurve((1.0, 5.0), (0.03, 0.08))) if curve else Damper(0.04)
    joints = (
        Joint("hip", Link(0.2, 0.3, 0.12, 1.5e-3), radians(90), 1, None, Spring(4.0, radians(100)), damper),
        Joint("knee", Link(0.15, 0.2, 0.05, 8e-4), radians(180), -1, None, Spring(1.5, radians(150)), Damper(0.02),
              {}, 2e-4),
    )  # fmt: skip
    return Leg("two links", joints, **{"tilt": radians(5), **more})


def test_outboard_inertia_is_the_mass_matrix_diagonal() -> None:
    found, pose = leg(), np.array([0.4, -0.9])
    matrix = mass_matrix(coefficients(found), pose, found.tilt)
    for j in range(2):
        assert swinging.outboard(found, j, pose)[0] == pytest.approx(matrix[j, j], rel=1e-12)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_energy_is_kept_beside_a_joint_that_nothing_holds(gravity: float) -> None:
    """On a table, or with a balanced load, without a spring: its period is infinite. It ended in a traceback."""
    joints = (
        Joint("yaw", Link(0.2, 1.0, -0.1, 0.01)),
        Joint("arm", Link(0.2, 0.5, 0.0, 0.005), spring=Spring(2.0, radians(10))),
    )
    found = Leg("free", joints, gravity=gravity)
    assert swinging._slowest(found, np.zeros(2)) == 0.0
    checks, left_out = swinging.swinging_checks(found)
    assert any("energy" in each.name for each in checks)
    assert all(each.passed for each in checks)
    # Each angle of the first joint is one of equilibrium: a test of it would be empty.
    assert [each.where for each in checks if each.name == "angle at equilibrium"] == ["arm"]
    assert any(text.startswith("equilibrium at the yaw: ") for text in left_out)


def test_a_leg_in_equilibrium_everywhere_has_no_check_of_it() -> None:
    """Without gravity and springs."""
    found = leg(gravity=0.0).with_joints(hip={"spring": None}, knee={"spring": None})
    checks, left_out = swinging.swinging_checks(found)
    assert checks == []
    assert sum("each angle is one" in text for text in left_out) == 2


def test_drives_are_said_to_be_unchecked_and_their_rotors_take_part(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All checks held without a word of the servos; with a rotor four failed, for it turned in one engine only."""
    motor = GearedMotor(3.0, 0.5, rotor_inertia=1e-3)
    driven = leg().with_joints(hip={"drive": Servo(gain=1.2, supply=12.0, control_period=7e-3, motor=motor)})
    write_leg(driven, tmp_path / "driven.leg.yaml")
    assert main(["check", str(tmp_path / "driven.leg.yaml"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["left_out"]
    assert any(text.startswith("the drive of hip: motor, servo and control steps are left out") for text in said)
    checks, said = swinging.swinging_checks(leg())
    assert all(check.passed for check in checks)
    assert not any("drive" in text for text in said)


def test_energies_link_by_link_are_the_coefficients_ones() -> None:
    found, state, rate = leg(), np.array([0.4, -0.9]), np.array([1.5, -3.0])
    other = energy(found, np.stack([state, 0 * state]), np.stack([rate, 0 * rate]))
    own = [
        swinging.potential(found, q) + swinging.kinetic(found, q, w) for q, w in ((state, rate), (0 * state, 0 * rate))
    ]
    assert own[0] - own[1] == pytest.approx(other[0] - other[1], rel=1e-12)


@pytest.mark.parametrize(
    ("ratio", "expected"),
    [
        (0.0, np.cos(3.0)),
        (1.0, exp(-3.0) * 4.0),
        (0.5, exp(-1.5) * (np.cos(3 * sqrt(0.75)) + np.sin(3 * sqrt(0.75)) * 0.5 / sqrt(0.75))),
        (2.0, ((2 + sqrt(3)) * exp(-(2 - sqrt(3)) * 3) - (2 - sqrt(3)) * exp(-(2 + sqrt(3)) * 3)) / (2 * sqrt(3))),
    ],
)
def test_the_damped_oscillator_is_the_textbook_one(ratio: float, expected: float) -> None:
    assert swinging.damped(1.0, ratio, 3.0) == pytest.approx(expected, rel=1e-9)


def test_a_period_is_read_between_samples() -> None:
    times = np.linspace(0.0, 4.3, 900)
    assert swinging.period(times, np.cos(2 * pi * times)) == pytest.approx(1.0, rel=1e-8)
    assert np.isnan(swinging.period(times, np.ones(900)))


def test_a_period_is_read_where_zero_is_a_sample() -> None:
    """Twenty samples a cycle with each crossing at one of them, of one and of three samples at zero."""
    times = np.arange(100) / 20.0
    swing = np.cos(2 * pi * times)
    for threshold in (1e-9, 0.4):
        resting = np.where(np.abs(swing) < threshold, -0.0, swing)
        assert swinging.period(times, resting) == pytest.approx(1.0, rel=1e-12)


def test_what_is_not_a_number_fails() -> None:
    assert not ModelCheck("a", "b", 1.0, float("nan"), 1.0, "1", "").passed


def test_a_balanced_link_has_no_pendulum(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With its centre of mass on the joint gravity does not swing it; the check ended in a ZeroDivisionError."""
    found = leg()
    wheel = replace(found.joints[1], link=Link(0.15, 0.2, 0.0, 8e-4))
    path = tmp_path / "balanced.leg.yaml"
    write_leg(replace(found, joints=(found.joints[0], wheel)), path)
    assert main(["check", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [c["where"] for c in document["checks"] if c["name"] == "period as a pendulum"] == ["hip"]
    assert "pendulum at the knee: what it carries is balanced, so gravity does not swing it" in document["left_out"]
    hanging = replace(wheel, spring=None)
    write_leg(replace(found, joints=(found.joints[0], hanging)), path)
    assert main(["check", str(path), "--json"]) == 0
    assert any("no stiffness" in text for text in json.loads(capsys.readouterr().out)["left_out"])


@pytest.mark.parametrize(("com", "tilt"), [(-0.06, 0.0), (0.06, radians(179.0)), (0.06, pi), (0.0, 0.0)])
def test_a_leg_that_nothing_holds_upright_is_checked_where_it_hangs(
    com: float, tilt: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A link without spring whose aligned pose is a maximum of energy, and a balanced one that has no minimum."""
    write_leg(Leg("one", (Joint("knee", Link(0.2, 0.2, com, 1e-3), 0.0),), tilt=tilt), tmp_path / "one.leg.yaml")
    assert main(["check", str(tmp_path / "one.leg.yaml")]) == 0
    said = capsys.readouterr().out
    assert "checks hold" in said
    assert ("energy: 10 deg away from equilibrium the leg has no more of it than there" in said) == (com == 0.0)


@pytest.mark.parametrize("curve", [False, True])
def test_a_leg_holds(curve: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "two.leg.yaml"
    write_leg(leg(curve), path)
    assert main(["check", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["passed"]
    names = [(check["name"], check["where"]) for check in document["checks"]]
    assert ("period as a pendulum", "knee") in names
    assert ("angle at equilibrium", "hip") in names
    assert len(names) >= 7


def test_a_light_last_link_hangs_straight_down() -> None:
    """Two links of 30 kg carry two of 3 g: the energy's descent ended 1 and 3 deg before the light ones hung."""
    sizes = ((2.0, 30.0, 10.0), (2.0, 30.0, 10.0), (0.02, 0.003, 1e-7), (0.02, 0.003, 1e-7))
    found = Leg("light end", tuple(
        Joint(f"j{j}", Link(length, mass, length / 2, inertia)) for j, (length, mass, inertia) in enumerate(sizes)
    ))  # fmt: skip
    checks = swinging.rest(found)
    assert all(each.passed for each in checks)
    assert [each.expected for each in checks] == pytest.approx([0.0] * 4, abs=1e-9)


def test_the_slope_of_the_potential_is_its_difference() -> None:
    found, pose = leg(), np.array([0.4, -0.9])
    step = 1e-6 * np.eye(2)
    energies = [[swinging.potential(found, pose + way * each) for way in (1.0, -1.0)] for each in step]
    assert swinging.turning(found, pose) == pytest.approx([(up - down) / 2e-6 for up, down in energies], rel=1e-7)


def test_a_leg_of_six_links_holds(tmp_path: Path) -> None:
    joints = tuple(
        Joint(f"j{i}", Link(0.1, 0.1, 0.05, 1e-4), spring=Spring(2.0 - 0.2 * i, 0.1 * i), damper=Damper(0.02))
        for i in range(6)
    )
    path = tmp_path / "six.leg.yaml"
    write_leg(Leg("six", joints), path)
    assert main(["check", str(path), "-q"]) == 0


def test_a_wrong_model_fails_with_the_place_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An engine whose gravity is a thousandth too large."""
    right = swinging.simulate

    def wrong(found: Leg, *rest: Any, **more: Any) -> Any:
        return right(replace(found, gravity=1.001 * found.gravity), *rest, **more)

    monkeypatch.setattr(swinging, "simulate", wrong)
    path, out = tmp_path / "two.leg.yaml", tmp_path / "out"
    write_leg(leg(), path)
    assert main(["check", str(path), "--out", str(out)]) == 1
    told = capsys.readouterr().out
    assert "FAILS" in told
    document = json.loads((out / "check.json").read_text())
    failed = {check["name"] for check in document["checks"] if not check["passed"]}
    assert {
        "period as a pendulum",
        "angle at equilibrium",
        "energy without dampers, relative to the energy released",
    } <= failed
    assert "angle after 0.3 periods as an oscillator" not in failed  # there is no gravity in it
    assert "checks of the model fail" in (out / "report.html").read_text()


def test_without_the_other_engine_the_check_is_reported_as_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    path = tmp_path / "two.leg.yaml"
    write_leg(leg(gravity=0.0), path)
    assert main(["check", str(path)]) == 0
    told = capsys.readouterr()
    assert "MuJoCo is not installed" in told.out
    assert "the leg has no gravity" in told.out


def test_the_example_hopper_holds(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)  # its drops have a test of their own: tests/hopper/test_mujoco.py
    out = tmp_path / "out"
    assert main(["check", str(EXAMPLES / "hopper" / "hopper.yaml"), "--out", str(out), "-q"]) == 0
    document = json.loads((out / "check.json").read_text())
    assert document["kind"] == "hopper"
    assert len(document["checks"]) == 7
    page = (out / "report.html").read_text()
    assert "The model holds in all 7 checks" in page


def test_a_wrong_hopper_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The planar form with a link a hundredth heavier."""
    right = jumping.planar_jump

    def wrong(found: Any, *rest: Any, **more: Any) -> Any:
        laminate = replace(found.laminate, mass_per_length=1.05 * found.laminate.mass_per_length)
        return right(replace(found, laminate=laminate), *rest, **more)

    monkeypatch.setattr(jumping, "planar_jump", wrong)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["check", str(EXAMPLES / "hopper" / "hopper.yaml"), "-q"]) == 1


def test_another_kind_of_file_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(EXAMPLES / "fit" / "fit.yaml")]) == 2
    assert "hopper" in capsys.readouterr().err


def test_the_other_engine_s_step_is_fine_enough_for_a_deep_crouch(tmp_path: Path) -> None:
    """MuJoCo's own step error of 0.15 mm failed a sound leg."""
    pytest.importorskip("mujoco")
    head = "part,vendor,gear_ratio [1],voltage [V],no_load_speed [rpm],stall_torque [N*m],stall_current [A],"
    row = "acme,50,12,400,0.6,3,0.15,40,0.5,me"
    (tmp_path / "motors.csv").write_text(
        f"{head}no_load_current [A],mass [g],torque_limit [N*m],source\nMY1,{row}\nMY2,{row}\n"
    )
    (tmp_path / "hopper.yaml").write_text(
        "kind: hopper-design\nmodel: D\nmotors: {use: [MY1], catalogs: [motors.csv], supply: 11.1 V, gearbox: warn}\n"
        "lengths: {least: 60 mm, most: 120 mm, step: 20 mm}\n"
        "leg: {hip_spacing: 20 mm, structure_mass: 60 g, bending: none, crouch: 45 deg, extended: 15 deg}\n"
    )
    assert main(["check", str(tmp_path / "hopper.yaml"), "-q"]) == 0
