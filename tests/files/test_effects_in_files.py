"""Effects in a leg file: values that cannot be together, and effects without the drive through which they act."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.swing.drive_needs import WORDS
from synth.swing.effects import effect_named, registered
from synth.swing.effects.definition import Effect
from synth.swing.leg_model import Joint, Leg, Link

LEG = """kind: leg
name: arm
joints:
  - name: arm
    zero: 90 deg
    sign: +1
    link: {length: 0.1 m, mass: 0.5 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}
"""
MOTOR = "motor: {resistance: 3.5 ohm, torque_constant: 2 mN*m/A, gear_ratio: 200}"
DRIVES = {
    "none": "",
    "torque servo": "{kind: servo, gain: 20 N*m/rad}",
    "servo": "{kind: servo, gain: 2 1/rad, supply: 12 V, " + MOTOR + "}",
    "linear": "{kind: servo, gain: 2 1/rad, supply: 12 V, commands: linear, " + MOTOR + "}",
    "voltage": "{kind: voltage, " + MOTOR + "}",
    "current": "{kind: torque, " + MOTOR + "}",
}
SERVOS = {"torque servo", "servo", "linear"}
DRIVEN = {"servo", "linear", "voltage"}
# Effect -> the drives with which it may act in some trial. A servo without a motor has no winding and no supply.
ACTS = {
    "servo_gain: {share: 0.1}": SERVOS,
    "command_delay: {delay: 10 ms}": SERVOS,
    "dead_band: {angle: 1 deg}": SERVOS,
    "command_rate_limit: {rate: 3 rad/s}": {"torque servo", "servo"},
    "current_limit: {torque: 0.01 N*m}": SERVOS | DRIVEN,
    "voltage_sag: {share: 0.5}": DRIVEN,
    "torque_constant: {share: 0.1}": DRIVEN,
    "winding_resistance: {share: 0.1}": DRIVEN,
    "winding_heating: {rise: 0.2, reference: 1 N*m}": DRIVEN,
    "gear_friction: {torque: 0.1 N*m}": {*DRIVES},
    "gear_friction: {share: 0.1}": {*DRIVES},  # by a torque column
    "torque_gain: {share: 0.5}": {*DRIVES},
    "gear_play: {play: 1 deg}": {*DRIVES},
}


def read(folder: Path, effect: str, drive: str = "", end: str = "") -> Leg:
    text = LEG + (f"    drive: {drive}\n" if drive else "") + f"    effects: [{{{effect}}}]\n{end}"
    (folder / "arm.leg.yaml").write_text(text, encoding="utf-8")
    return read_leg(folder / "arm.leg.yaml")


def refusal(folder: Path, effect: str, drive: str = "") -> str:
    with pytest.raises(UserError) as refused:
        read(folder, effect, drive)
    (problem,) = refused.value.problems
    assert problem.line is not None
    return str(problem).split("arm.leg.yaml:")[1]


@pytest.mark.parametrize(
    ("effect", "wanted"),
    [
        (
            "joint_stop: {upper: 150 deg, lower: 290 deg, stiffness: 5 N*m/rad}",
            "joint_stop.upper: 150 deg is not allowed: it must be at least lower, which is 290 deg",
        ),
        ("joint_stop: {stiffness: 5 N*m/rad}", '"upper" or "lower" is missing: write one or more, for example '),
        (
            "encoder_offset: {offset: 5 deg, controlled: 0.5}",
            "controlled: 0.5 is not allowed: it must be 0 (the true angle) or 1 (this reading)",
        ),
        ("encoder_scale: {error: -1}", "error: -1 is not allowed: it must be more than -1"),
        ("gear_play: {play: 1 deg, damping: -1 s/rad}", "-1 s/rad is not allowed: it must be at least 0"),
        ("gear_play: {play: 1 deg, read_beyond: 2}", "it must be 0 (before the play) or 1 (behind the play)"),
    ],
)
def test_values_that_cannot_be_are_refused(effect: str, wanted: str, tmp_path: Path) -> None:
    """Crossed stops were taken, and the diagnosis gave no answer in ten minutes."""
    assert wanted in refusal(tmp_path, effect)


@pytest.mark.parametrize("lower", ["290 deg", f"{290.0 * 0.017453292519943295 * (1.0 + 1e-15)!r} rad"])
def test_equal_ends_of_a_stop_are_read_again_as_written(lower: str, tmp_path: Path) -> None:
    """In whatever unit: a diagnosis may end there."""
    leg = read(tmp_path, f"joint_stop: {{upper: 290 deg, lower: {lower}, stiffness: 5 N*m/rad}}")
    write_leg(leg, tmp_path / "again.leg.yaml")
    again = read_leg(tmp_path / "again.leg.yaml").joints[0].effects["joint_stop"]
    assert again == pytest.approx(dict(leg.joints[0].effects["joint_stop"]), rel=1e-14)


@pytest.mark.parametrize("drive", DRIVES)
def test_an_effect_without_the_drive_by_which_it_acts_is_refused(drive: str, tmp_path: Path) -> None:
    for effect, with_drives in ACTS.items():
        name = effect.partition(":")[0]
        if drive in with_drives:
            assert list(read(tmp_path, effect, DRIVES[drive]).joints[0].effects) == [name]
        else:
            found = refusal(tmp_path, effect, DRIVES[drive])
            assert f'"{name}" needs a ' in found
            assert found.endswith("which arm lacks; state that in `drive:`, or leave the effect out")


def test_a_common_supply_needs_several_motors(tmp_path: Path) -> None:
    shared = "effects: [{shared_source_resistance: {resistance: 0.2 ohm}}]\n"
    text = LEG + f"    drive: {DRIVES['servo']}\n"
    path = tmp_path / "arm.leg.yaml"
    path.write_text(text + shared, encoding="utf-8")
    with pytest.raises(UserError, match="needs several servos with motors on one supply, which the leg lacks"):
        read_leg(path)
    second = text[text.index("  - name") :].replace("arm", "hand")
    path.write_text(text + second + shared, encoding="utf-8")
    assert read_leg(path).effects == {"shared_source_resistance": {"resistance": pytest.approx(0.2)}}


def test_a_mistake_of_the_drive_alone_is_told(tmp_path: Path) -> None:
    assert '"gain" is missing' in refusal(tmp_path, "servo_gain: {share: 0.1}", "{kind: servo}")
    assert "1 kg" in refusal(tmp_path, "servo_gain: {share: 0.1}", "{kind: servo, gain: 1 kg}")


def test_an_effect_of_the_users_declares_what_its_file_may_say(tmp_path: Path) -> None:
    mine = replace(effect_named("hardening_spring"), name="mine", ascending=("onset", "reach"), any_of=("onset",))

    def problem(effects: dict[str, float], known: Effect) -> str:
        link = Link(0.1, 0.5, 0.05, 1e-3)
        leg = Leg("one", (Joint("knee", link, effects={"mine": {"stiffening": 1.0, **effects}}),))
        write_leg(leg, tmp_path / "x.leg.yaml", effects=[known])
        with pytest.raises(UserError) as refused:
            read_leg(tmp_path / "x.leg.yaml", effects=[known])
        return refused.value.problems[0].text

    assert problem({}, mine).startswith('"onset" is missing: write one')
    assert problem({"onset": 2.0, "reach": 1.0}, mine) == (
        "1 rad is not allowed: it must be at least onset, which is 2 rad"
    )


def test_every_need_of_an_effect_of_drives_has_words() -> None:
    """Else the effect is taken to act without a drive."""
    for effect in registered():
        assert effect.way != "drive" or (effect.needs and set(effect.needs) <= set(WORDS)), effect.name


@pytest.mark.parametrize("name", ["servo_gain", "torque_constant", "winding_resistance"])
def test_a_gain_or_resistance_cannot_fall_below_nothing(tmp_path: Path, name: str) -> None:
    """At -100 % nothing is left of it; a negative one feeds the joint or turns its motor round."""
    assert refusal(tmp_path, f"{name}: {{share: -1.2}}", DRIVES["servo"]).endswith(
        f"{name}.share: -1.2 is not allowed: it must be more than -1"
    )
    read(tmp_path, f"{name}: {{share: -0.99}}", DRIVES["servo"])
