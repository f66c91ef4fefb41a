"""The generator of servo-driven legs against the program's engine, and its rigs as the files say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.servo_engine import COLUMNS, Rig, follow, shown_as
from blind.servos import LIBRARY, OUTSIDE, Setup, _level, _rms, _setup, _write, make_case, plan
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project
from synth.fit.recordings import recordings
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.swing.readings import as_stated


@pytest.mark.parametrize(
    ("seed", "source"),
    [(1, 0.0), (2, 0.4), *(pytest.param(*each, marks=pytest.mark.slow) for each in ((2, 0.0), (3, 0.0), (3, 0.4)))],
)
def test_both_engines_move_a_leg_alike(seed: int, source: float, tmp_path: Path) -> None:
    """Two engines that share no line, each holding every command: 0.1 ms steps against RK5(4).

    ``source`` : resistance of the source of all joints, over that of the first winding.
    """
    rng = np.random.default_rng(seed)
    setup = _setup(rng)
    rig = Rig(setup.design.joints, source * float(setup.design.joints[0, 8]))
    moved = setup.moved(rig)
    joints = len(setup.design.joints)
    _write(rng, setup, moved, 0.0, [f"joint{k + 1}" for k in range(joints)], tmp_path / "rig")
    project = read_gap_project(tmp_path / "rig" / "gap.yaml")
    leg = with_source(project.leg, rig.source)
    for k, recording in enumerate(recordings(project.leg, project.trials, ())):
        start = moved[k][0]
        found = simulate(leg, start, 0.0 * start, recording.time, signals=recording.signals, tolerance=1e-8)
        assert np.degrees(np.sqrt(np.mean((found - moved[k]) ** 2))) < 0.0005


@pytest.mark.parametrize(("rate", "delay"), [(2.0, 0.0), (6.0, 0.013)])
def test_both_engines_limit_a_command_s_rate_alike(rate: float, delay: float, tmp_path: Path) -> None:
    setup = _setup(np.random.default_rng(1))
    moved = setup.moved(setup.design.changed(0, rate=rate, delay=delay))
    _write(np.random.default_rng(1), setup, moved, 0.0, ["joint1"], tmp_path / "rig")
    project = read_gap_project(tmp_path / "rig" / "gap.yaml")
    effects = {"command_rate_limit": {"rate": rate}, "command_delay": {"delay": delay}}
    leg = project.leg.with_joints(joint1={"effects": effects})
    for k, recording in enumerate(recordings(project.leg, project.trials, ())):
        start = moved[k][0]
        found = simulate(leg, start, 0.0 * start, recording.time, signals=recording.signals, tolerance=1e-8)
        assert np.degrees(np.sqrt(np.mean((found - moved[k]) ** 2))) < 0.002  # of 0.0015 to 0.006 of noise


@pytest.mark.parametrize("joints", [1, 2])
def test_both_engines_control_what_the_encoder_reads(joints: int, tmp_path: Path) -> None:
    """A shift and a wrong scale at every joint, and a command that comes late."""
    setup = next(s for s in map(_setup, map(np.random.default_rng, range(9))) if len(s.design.joints) == joints)
    rig, names = setup.design, [f"joint{k + 1}" for k in range(joints)]
    for j in range(joints):
        rig = rig.changed(j, shift=0.12 - 0.2 * j, scaled=0.08 - 0.15 * j, delay=0.01)
    moved = setup.moved(rig)
    _write(np.random.default_rng(1), setup, moved, 0.0, names, tmp_path / "rig")
    project = read_gap_project(tmp_path / "rig" / "gap.yaml")

    def error(controlled: float) -> float:
        effects = {name: {"effects": encoder(rig, j, controlled)} for j, name in enumerate(names)}
        leg = project.leg.with_joints(**effects)
        worst = 0.0
        for k, recording in enumerate(recordings(project.leg, project.trials, ())):
            start = [true_angle(leg, j, read) for j, read in enumerate(moved[k][0].tolist())]
            out = simulate(
                leg, start, np.zeros(joints), recording.time, rates=True, signals=recording.signals, tolerance=1e-8
            )
            read = as_stated(leg, recording.time, out[:, :joints], out[:, joints:])
            worst = max(worst, float(np.degrees(np.sqrt(np.mean((read - moved[k]) ** 2)))))
        return worst

    assert error(1.0) < 0.0005
    assert error(0.0) > 1.0


def encoder(rig: Rig, joint: int, controlled: float) -> dict[str, dict[str, float]]:
    """The same errors in a leg file: the other engine scales a reading before it shifts it."""
    shift, scaled, delay = (float(rig.joints[joint, COLUMNS.index(name)]) for name in ("shift", "scaled", "delay"))
    return {
        "encoder_offset": {"offset": shift / (1.0 + scaled), "controlled": controlled},
        "encoder_scale": {"error": scaled, "controlled": controlled},
        "command_delay": {"delay": delay},
    }


def true_angle(leg: Leg, joint: int, read: float) -> float:
    """Rad, the angle at which an encoder of ``leg`` reads ``read``: the reading is linear in the angle."""
    angles = np.zeros((2, len(leg.joints)))
    angles[1, joint] = 1.0
    zero, one = as_stated(leg, np.arange(2.0), angles, 0.0 * angles)[:, joint]
    return float((read - zero) / (one - zero))


def with_source(leg: Leg, ohms: float) -> Leg:
    if len(leg.joints) > 1:
        return replace(leg, effects={"shared_source_resistance": {"resistance": ohms}})
    motor = leg.joints[0].drive.motor  # type: ignore[union-attr]
    share = ohms / motor.resistance  # type: ignore[union-attr]
    return leg.with_joints(**{leg.joints[0].name: {"effects": {"voltage_sag": {"share": share}}}})


def test_friction_holds_a_joint_that_the_motor_cannot_move() -> None:
    setup = _setup(np.random.default_rng(1))
    stuck = setup.design.changed(0, dry=50.0)
    moved = follow(stuck, setup.times, setup.commands[0], setup.supply)
    np.testing.assert_allclose(moved[:, 0], moved[0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "effect"),
    [("single", "gear_friction"), ("none", "gear_friction")],
)
@pytest.mark.slow  # half a minute each
def test_a_rig_is_as_large_as_its_answer_says(kind: str, effect: str, tmp_path: Path) -> None:
    name, answer = make_case(77, 3, kind, effect, tmp_path)
    project = read_gap_project(tmp_path / name / "gap.yaml")
    assert sum(trial.held_out for trial in project.trials) == 2
    assert len(answer["effects"]) == (kind == "single")
    assert len({cause["effect"] for cause in answer["small"]} - {"latency"}) == 3
    if kind == "single":
        assert answer["before_deg"] > 20.0 * answer["noise_floor_deg"]
        assert answer["best_possible_deg"] < 0.4 * answer["before_deg"]


def test_what_cannot_be_told_apart_is_as_right() -> None:
    """The answers once held one of these alone: a diagnosis that named the other counted as a false alarm."""
    setups = [_setup(np.random.default_rng(k)) for k in range(9)]
    two = next(s for s in setups if len(s.design.joints) == 2)
    at = [LIBRARY["voltage_sag"](two.design, j, 0.3) for j in range(2)]
    np.testing.assert_array_equal(two.moved(at[0]), two.moved(at[1]))
    assert shown_as("voltage_sag", 1, 2) == [("shared_source_resistance", -1)]
    assert shown_as("voltage_sag", 0, 1) == [("voltage_sag", 0)]
    one = next(s for s in setups if len(s.design.joints) == 1)
    late = one.moved(one.design.changed(0, delay=0.02))
    np.testing.assert_allclose(late[:, 4:], one.moved(one.design)[:, :-4], atol=1e-3)
    assert shown_as("command_delay", 0, 1) == [("command_delay", 0), ("latency", 0)]
    assert shown_as("command_delay", 0, 2) == [("command_delay", 0)]


def test_every_cause_is_planted_in_turn() -> None:
    drawn = [effect for _, kind, effect in plan(1, 100) if kind == "single"]
    assert {drawn.count(effect) for effect in LIBRARY} <= {3, 4, 5}
    assert {effect for _, kind, effect in plan(1, 80) if kind == "unknown"} == set(OUTSIDE)


class Long(Setup):
    """Logs of 20 s, which show a winding warm; the last one scores."""

    @property
    def times(self) -> np.ndarray:
        """(m,) s, at 50 Hz."""
        return np.arange(0.0, 20.0, 0.02)

    @property
    def held_out(self) -> range:
        """Places of the logs that only score."""
        return range(3, 4)


@pytest.mark.slow  # like the other causes of a servo, in longer logs
def test_a_warming_winding_is_found_in_long_logs(tmp_path: Path) -> None:
    """Steps that hold the leg up, which both engines hold exactly; the resistance grows in the other engine."""
    short = _setup(np.random.default_rng(1))
    assert len(short.design.joints) == 1
    rng = np.random.default_rng(1)
    commands = tuple(np.repeat(np.r_[0.0, rng.uniform(-1.2, 1.2, 7)], 125)[:, None] for _ in range(4))
    setup = Long(short.design, short.supply, commands)
    hot = setup.design.changed(0, rise=0.5, reference=0.7 * _level(setup.design, 0), warming=15.0)
    whole = setup.moved(hot)
    assert np.degrees(_rms(whole - setup.moved(setup.design))) > 0.1
    _write(np.random.default_rng(2), setup, whole, 1e-4, ["joint1"], tmp_path / "hot")
    project = read_gap_project(tmp_path / "hot" / "gap.yaml")
    found = diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json()
    assert found["verdict"] in ("effect", "tie")
    assert found["ranked"][0]["effect"] == "winding_heating"
    assert found["ranked"][0]["parameters"]["time"]["value"] == pytest.approx(15.0, rel=0.4)
