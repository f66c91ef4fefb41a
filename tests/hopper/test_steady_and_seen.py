"""Stall and free-speed tests, a link's bending pairs, a video's heights and a meter's currents."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synth.cli import main
from synth.errors import UserError
from synth.files.bending_pairs import read_bending
from synth.files.hopper_project import read_hopper_project
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.motors import motor_of
from synth.hopper.seen_jumps import push_current, rise_of_point
from synth.hopper.steady_motor import steady_motor
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.outcomes import outcome_of
from synth.parts.catalogs import Catalogue

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "hopper" / "hopper.yaml"
RESISTANCE, EMF, FRICTION, VISCOUS, RATIO, EFFICIENCY = 4.0, 1.6e-3, 5e-5, 2e-8, 210.0, 0.55


def write(path: Path, header: str, rows: Any) -> None:
    np.savetxt(path, np.asarray(rows), delimiter=",", header=header, comments="")


def motor_tests(folder: Path, noise: float = 0.0) -> None:
    """Points of a known motor: held at four voltages, and free at four."""
    rng = np.random.default_rng(1)
    held, free = [], []
    for volts in (1.5, 3.0, 4.5, 6.0):
        current = volts / RESISTANCE
        held.append((volts, current, RATIO * EFFICIENCY * (EMF * current - FRICTION)))
        # V = R i + K w, K i = f + b w with w at the rotor
        speed = (volts * EMF / RESISTANCE - FRICTION) / (VISCOUS + EMF**2 / RESISTANCE)
        free.append((volts, (FRICTION + VISCOUS * speed) / EMF, speed / RATIO))
    for name, rows, last in (("stall", held, "torque [N*m]"), ("free", free, "speed [rad/s]")):
        values = np.array(rows)
        values[:, 1:] *= 1 + noise * rng.standard_normal(values[:, 1:].shape)
        write(folder / f"{name}.csv", f"voltage [V],current [A],{last}", values)


def motor_result(folder: Path, keys: str, out: str = "out") -> dict[str, Any]:
    (folder / "motor.yaml").write_text(f"kind: hopper-motor\ngear_ratio: 210\n{keys}")
    assert main(["hopper", str(folder / "motor.yaml"), "--out", str(folder / out), "-q"]) == 0
    found: dict[str, Any] = json.loads((folder / out / "motor.json").read_text())["steady"]
    return found


def test_stall_and_free_speed_determine_the_steady_constants(tmp_path: Path) -> None:
    motor_tests(tmp_path)
    found = motor_result(tmp_path, "stall: [stall.csv]\nfree_speed: [free.csv]\n")["motor"]
    true = {"resistance": RESISTANCE, "back_emf_constant": EMF, "friction": FRICTION, "viscous": VISCOUS,
            "torque_constant": EFFICIENCY * EMF}  # fmt: skip
    for key, value in true.items():
        assert found[key]["value"] == pytest.approx(value, rel=1e-6), key
        assert found[key]["interval90"][0] < value < found[key]["interval90"][1]


def test_noisy_points_lie_in_their_intervals(tmp_path: Path) -> None:
    motor_tests(tmp_path, 0.01)
    found = motor_result(tmp_path, "stall: [stall.csv]\nfree_speed: [free.csv]\n")["motor"]
    for key, value in (("resistance", RESISTANCE), ("back_emf_constant", EMF), ("torque_constant", EFFICIENCY * EMF)):
        low, high = found[key]["interval90"]
        assert low < value < high, key


@pytest.mark.parametrize(
    ("held", "free"),
    [
        ([3.0, 4.5, 6.0], [3.0, 4.5, 6.0]),
        (np.linspace(2.0, 6.0, 5), np.linspace(2.0, 6.0, 5)),
        (np.linspace(1.5, 6.0, 12), np.linspace(1.5, 6.0, 12)),
        ([6.0], [6.0, 6.0]),
    ],
)
@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_intervals_of_few_points_hold(held: Any, free: Any, noise: float) -> None:
    """Of 500 motors read with an error in proportion, 90 % intervals hold; 85 % or less by chance once in 5000.

    Of three points the normal distribution's held 65 to 82 %.
    """
    rng, volts, free_volts = np.random.default_rng(0), np.array(held), np.array(free)
    if len(volts) == 1 and noise != 0.02:
        pytest.skip("a single reading is assumed to be 2 % off")
    speed = (free_volts * EMF / RESISTANCE - FRICTION) / (VISCOUS + EMF**2 / RESISTANCE)
    torque = RATIO * EFFICIENCY * (EMF * volts / RESISTANCE - FRICTION)
    true = {"resistance": RESISTANCE, "back_emf": EMF, "friction": FRICTION, "viscous": VISCOUS,
            "torque_constant": EFFICIENCY * EMF}  # fmt: skip
    if len(volts) == 1:
        true["friction"] += VISCOUS * speed[0]  # at one speed its viscous part is in it
        torque = RATIO * EFFICIENCY * (EMF * volts / RESISTANCE - true["friction"])
        del true["viscous"]

    def read(values: Any) -> Any:
        return values * (1.0 + noise * rng.standard_normal(len(values)))

    hits = dict.fromkeys(true, 0)
    for _ in range(500):
        free_current = (FRICTION + VISCOUS * speed) / EMF
        stall = {"voltage": volts, "current": read(volts / RESISTANCE), "torque": read(torque)}
        running = {"voltage": free_volts, "current": read(free_current), "speed": read(speed / RATIO)}
        found = steady_motor([HopperRecording("stall", stall)], [HopperRecording("free", running)], RATIO).constants
        for name, value in true.items():
            low, high = found[name].interval90
            hits[name] += low <= value <= high
    assert all(0.85 < count / 500 < 0.95 for count in hits.values()), hits


def test_one_stall_current_gives_the_torque_constant_with_the_friction_of_free_runs(tmp_path: Path) -> None:
    motor_tests(tmp_path)
    one = np.loadtxt(tmp_path / "stall.csv", delimiter=",", skiprows=1)[1:2]
    write(tmp_path / "stall.csv", "voltage [V],current [A],torque [N*m]", one)
    found = motor_result(tmp_path, "stall: [stall.csv]\nfree_speed: [free.csv]\n")["motor"]["torque_constant"]
    assert found["value"] == pytest.approx(EFFICIENCY * EMF, rel=1e-6)
    alone = motor_result(tmp_path, "stall: [stall.csv]\n", "alone")
    assert set(alone["motor"]) == {"resistance", "torque_per_current_at_stall"}
    lost = EFFICIENCY * FRICTION / one[0, 1]
    assert alone["motor"]["torque_per_current_at_stall"]["value"] == pytest.approx(EFFICIENCY * EMF - lost)
    assert any("apart from friction" in text for text in alone["not_determined"])


def test_what_one_test_cannot_determine_is_reported(tmp_path: Path) -> None:
    motor_tests(tmp_path)
    alone = motor_result(tmp_path, "stall: [stall.csv]\n")
    assert set(alone["motor"]) == {"resistance", "torque_constant"}
    assert any("free-speed test" in text for text in alone["not_determined"])
    one = np.loadtxt(tmp_path / "free.csv", delimiter=",", skiprows=1)[:1]
    write(tmp_path / "free.csv", "voltage [V],current [A],speed [rad/s]", one)
    both = motor_result(tmp_path, "stall: [stall.csv]\nfree_speed: [free.csv]\n", "both")
    assert "viscous" not in both["motor"]
    assert both["motor"]["friction"]["value"] == pytest.approx(EMF * one[0, 1])


def test_what_run_ups_determine_is_not_missing_beside_them(tmp_path: Path) -> None:
    """Inductance and inertia stood with values and as not determined on one screen."""
    motor_tests(tmp_path)
    records = {
        name: HopperRecording(name, dict(zip(("voltage", "current", last), np.loadtxt(
            tmp_path / f"{name}.csv", delimiter=",", skiprows=1).T, strict=True)))
        for name, last in (("stall", "torque"), ("free", "speed"))
    }  # fmt: skip
    stall, free = [records["stall"]], [records["free"]]
    for held, running, alone in ((stall, free, 1), (stall, [], 2), ([], free, 2)):
        assert len(steady_motor(held, running, RATIO).not_determined) == alone
        assert steady_motor(held, running, RATIO, with_runs=True).not_determined == ()


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("", 'needs "runs"'),
        ("stall: [free.csv]\n", 'no column "torque [N*m]"'),
        ("free_speed: [still.csv]\n", "free speed is 0"),
        ("stall: [backward.csv]\n", "against its voltage"),
        ("stall: [stall.csv]\nfree_speed: [held.csv]\n", "leave no voltage for the speed"),
        ("stall: [stall.csv]\nfree_speed: [rising.csv]\n", "as if the motor stood still"),
    ],
)
def test_mistakes_are_reported(keys: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motor_tests(tmp_path)
    write(tmp_path / "still.csv", "voltage [V],current [A],speed [rad/s]", [(6.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
    write(tmp_path / "backward.csv", "voltage [V],current [A],torque [N*m]", [(6.0, -1.0, 0.2), (3.0, 1.0, 0.1)])
    write(tmp_path / "held.csv", "voltage [V],current [A],speed [rad/s]", [(6.0, 1.51, 0.2), (3.0, 0.1, 9.0)])
    rising = [(3.0, 0.02, 8.0), (4.0, 0.3, 11.0), (5.0, 0.6, 14.0)]
    write(tmp_path / "rising.csv", "voltage [V],current [A],speed [rad/s]", rising)
    (tmp_path / "motor.yaml").write_text(f"kind: hopper-motor\ngear_ratio: 210\n{keys}")
    assert main(["hopper", str(tmp_path / "motor.yaml"), "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err


def test_a_slope_with_an_offset_is_the_rate(tmp_path: Path) -> None:
    """Ten pairs of 12 N*m/rad, the gauge 0.02 N*m off, 0.01 N*m of noise."""
    rng = np.random.default_rng(4)
    degrees = np.linspace(0.5, 6.0, 10)
    torque = 0.02 + 12.0 * np.radians(degrees) + 0.01 * rng.standard_normal(10)
    write(tmp_path / "pairs.csv", "deflection [deg],torque [N*m]", np.column_stack([degrees, torque]))
    found = read_bending(tmp_path / "pairs.csv", "pairs.csv")
    assert found.interval90[0] < 12.0 < found.interval90[1]
    assert found.rate == pytest.approx(12.0, rel=0.03)
    assert found.offset == pytest.approx(0.02, abs=0.02)


@pytest.mark.parametrize(("of_deflection", "of_torque"), [(0.4, 0.0), (0.0, 0.1), (0.2, 0.03)])
def test_the_interval_of_a_bending_rate_holds_whichever_is_read_with_errors(
    tmp_path: Path, of_deflection: float, of_torque: float
) -> None:
    """With a deflection read within 0.4 deg of 4 it held 66 %. Of 60, 48 or fewer hold by chance once in 69 times."""
    held, torque = 0, np.linspace(0.0, 1.0, 20)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        pairs = [
            np.degrees(torque / 14.0) + of_deflection * rng.normal(size=20), torque + of_torque * rng.normal(size=20)
        ]  # fmt: skip
        write(tmp_path / "pairs.csv", "deflection [deg],torque [N*m]", np.column_stack(pairs))
        low, high = read_bending(tmp_path / "pairs.csv", "pairs.csv").interval90
        held += low <= 14.0 <= high
    assert held > 48


def test_bending_pairs_stand_for_the_rate_in_a_design(tmp_path: Path) -> None:
    write(tmp_path / "pairs.csv", "deflection [deg],torque [N*mm]", [(d, 11e3 * np.radians(d)) for d in (1, 2, 4)])
    text = EXAMPLE.read_text()
    measured = text.replace("beam_rate: 14.0224 N*m/rad", "bending: pairs.csv")
    assert measured != text
    (tmp_path / "hopper.yaml").write_text(measured)
    found = read_hopper_project(tmp_path / "hopper.yaml")
    assert found.leg.laminate.beam_rate(0.12) == pytest.approx(11.0, rel=1e-6)
    assert any(d.key == "laminate.beam_rate" and "measured" in d.reason for d in found.defaults)
    (tmp_path / "hopper.yaml").write_text(text.replace("beam_rate: 14", "bending: pairs.csv, beam_rate: 14"))
    with pytest.raises(UserError, match="both given"):
        read_hopper_project(tmp_path / "hopper.yaml")


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([(1, 0.1), (2, 0.2)], "at least 3"),
        ([(1, -0.1), (2, -0.2), (3, -0.3)], "wrong sign"),
        ([(1, 0.1), (2, 0.9), (3, 0.2), (4, 0.9)], "no straight line"),
    ],
)
def test_pairs_that_are_no_spring_are_refused(rows: list[tuple[float, float]], told: str, tmp_path: Path) -> None:
    write(tmp_path / "pairs.csv", "deflection [deg],torque [N*m]", rows)
    with pytest.raises(UserError, match=told):
        read_bending(tmp_path / "pairs.csv", "pairs.csv")


def test_video_and_meter_of_model_d_agree_with_model_d(tmp_path: Path) -> None:
    """Made by model D at 240 frames and 1000 samples a second: its own predictions lie within the sampling."""
    shutil.copy(EXAMPLE, tmp_path)
    project = read_hopper_project(EXAMPLE)
    leg, rows = project.leg.with_length(0.12), [row for row in Catalogue.load().motors if row.complete]
    motors = [motor_of(row, project.motor_options) for row in rows]
    jumps = simulate([(leg, motor) for motor in motors], project.contact, MODELS["D"])
    best = int(np.argmax([jump.clearance for jump in jumps]))
    row, motor = rows[best], motors[best]
    jumper, layout = compiled_jump(leg.bending), LAYOUTS[leg.bending]
    parameters = lane(leg, motor, project.contact, MODELS["D"])
    outcome, trace = outcome_of(jumper.run(parameters[:, None])[:, 0]), jumper.trace(parameters)
    frames, ticks = np.arange(-0.1, trace[-1, 0], 1 / 240), np.arange(-0.05, outcome.takeoff_time, 1e-3)
    foot = np.interp(frames, trace[:, 0], trace[:, 1 + layout.row("foot")], left=0.0)
    drawn = np.where(ticks < 0, 0.0, np.interp(ticks, trace[:, 0], trace[:, 1 + layout.row("drawn")]))
    write(tmp_path / "video.csv", "time [s],height [mm]", np.column_stack([frames, 1e3 * foot + 812.0]))
    write(tmp_path / "meter.csv", "time [s],current [A]", np.column_stack([ticks, drawn]))
    (tmp_path / "jumps.yaml").write_text(
        f'kind: hopper-jumps\ndesign: hopper.yaml\nmotor: "{row.part}"\nlength: 120 mm\n'
        "heights: [{file: video.csv, point: foot}]\ncurrents: [meter.csv]\n"
    )
    assert main(["hopper", str(tmp_path / "jumps.yaml"), "--out", str(tmp_path / "out")]) == 0
    seen = json.loads((tmp_path / "out" / "jumps.json").read_text())["seen"]
    assert seen["height_of_foot"]["mean"]["value"] == pytest.approx(outcome.clearance, abs=5e-4)
    assert abs(seen["height_of_foot"]["models"]["D"]["over_measured"]) < 0.02
    assert abs(seen["peak_current"]["models"]["D"]["over_measured"]) < 0.02
    assert abs(seen["charge"]["models"]["D"]["over_measured"]) < 0.05


@pytest.mark.parametrize("on", [0.06, 0.15, 0.3])
def test_a_charge_is_that_of_the_time_for_which_the_motors_are_on(
    on: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A meter of the complete model: in the push, in flight with the leg on its stop, and after the landing."""
    shutil.copy(EXAMPLE, tmp_path)
    project = read_hopper_project(EXAMPLE)
    leg, motor = project.leg.with_length(0.12), motor_of(Catalogue.load().find_motor("N20 HP 6V 150:1"))
    jumper = compiled_jump(leg.bending)
    trace = jumper.trace(lane(leg, motor, project.contact, MODELS["full"]), duration=0.5, fall=99.0)
    ticks = np.arange(-0.05, 0.4, 1e-3)
    drawn = np.interp(ticks, trace[:, 0], trace[:, 1 + jumper.layout.row("drawn")])
    meter = np.where((ticks >= 0) & (ticks < on), drawn, 0.0) + 0.01 * np.random.default_rng(1).normal(size=len(ticks))
    write(tmp_path / "meter.csv", "time [s],current [A]", np.column_stack([ticks, meter]))
    (tmp_path / "jumps.yaml").write_text(
        'kind: hopper-jumps\ndesign: hopper.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\ncurrents: [meter.csv]\n'
    )
    words = ["hopper", str(tmp_path / "jumps.yaml"), "--out", str(tmp_path / "out"), "-q"]
    assert main(words if on < 0.1 else [*words, "--json"]) == 0
    written, printed = (tmp_path / "out" / "jumps.json").read_text(), capsys.readouterr().out
    seen = json.loads(written)["seen"]
    if on < 0.1:
        assert "charge" in printed
    else:
        assert json.loads(printed) == json.loads(written)
    assert seen["charge"]["measured"][0]["lasting"]["value"] == pytest.approx(on, abs=2.5e-3)
    assert abs(seen["charge"]["models"]["full"]["over_measured"]) < 0.02
    assert abs(seen["peak_current"]["models"]["full"]["over_measured"]) < 0.02


@pytest.mark.parametrize("written", ["link_mass: 5 g", "beam_rate: 3 N*m/rad", "reference_length: 90 mm"])
def test_a_measured_link_beside_the_strip_is_refused(tmp_path: Path, written: str) -> None:
    """It was ignored; without it the defaults of a measured link are not told either."""
    text = "kind: hopper-design\nlaminate: {links: strip"
    path = tmp_path / "a.yaml"
    path.write_text(f"{text}, {written}}}\n")
    with pytest.raises(UserError, match="belongs to a measured link") as raised:
        read_hopper_project(path)
    assert written.split(":")[0] in str(raised.value)
    path.write_text(f"{text}}}\n")
    assert not {"laminate.link_mass", "laminate.beam_rate"} & {item.key for item in read_hopper_project(path).defaults}


def test_current_before_the_push_is_not_the_motors() -> None:
    """It counted: 0.1 A of electronics took 3 % off every model's peak over the measured one."""
    time = np.arange(400) * 1e-3
    motors = np.where((time >= 0.1) & (time < 0.25), 0.5 + 2.5 * np.exp(-(time - 0.1) / 0.02), 0.0)
    alone = push_current("a.csv", time, motors)
    for other in (0.1, -0.1):
        np.testing.assert_allclose(push_current("a.csv", time, motors + other), alone, rtol=1e-9)


def test_a_video_without_a_jump_is_refused() -> None:
    still = 1e-4 * np.sin(np.arange(100.0))
    with pytest.raises(UserError, match="is it a jump"):
        rise_of_point("a.csv", still)
    with pytest.raises(UserError, match="begins during the jump"):
        rise_of_point("a.csv", np.concatenate([[0.0, 0.05, 0.1], np.linspace(0.1, 0.0, 50)]))
    with pytest.raises(UserError, match="no push"):
        push_current("b.csv", np.arange(100) * 1e-3, -np.ones(100))


def recorded_files(folder: Path) -> dict[str, str]:
    """A file of each kind that ``synth hopper`` reads, with its recordings beside it, and a mistake in each."""
    shutil.copy(EXAMPLE, folder)
    motor_tests(folder)
    ticks = np.arange(0.0, 1.0, 1e-2)
    write(folder / "video.csv", "time [s],height [mm]", np.column_stack([ticks, ticks]))
    write(folder / "pull.csv", "time [s],upper link [deg],hip torque [N*m]", np.column_stack([ticks, ticks, ticks]))
    jump = 'kind: hopper-jumps\ndesign: hopper.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\n'
    texts = {
        "motor": "kind: hopper-motor\ngear_ratio: 210\nstall: [stall.csv]\nfree_speed: [free.csv]\n",
        "pulls": "kind: hopper-pull-ups\ndesign: hopper.yaml\nbody_mass: 0.1 kg\n"
        "trials: [{file: pull.csv, length: 120 mm}]\n",
        "jumps": jump + "heights: [{file: video.csv, point: foot}]\n",
        "hopper": (folder / "hopper.yaml").read_text(),
    }
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    return texts


@pytest.mark.parametrize("kind", ["motor", "pulls", "jumps", "hopper", "--truth"])
def test_a_dry_run_reads_and_writes_nothing(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Recordings were identified, the published leg was simulated for half a minute, and both were written."""
    recorded_files(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    given = kind if kind == "--truth" else str(tmp_path / f"{kind}.yaml")
    assert main(["hopper", given, "--out", str(tmp_path / "out"), "--dry-run"]) == 0
    assert sorted(tmp_path.rglob("*")) == before
    told = capsys.readouterr().out
    assert ("is valid" in told) == (kind != "--truth"), told


@pytest.mark.parametrize(
    ("kind", "old", "new", "told"),
    [
        ("motor", "free.csv", "fre.csv", "fre.csv"),
        ("pulls", "120 mm", "120", "length"),
        ("jumps", "N20 HP 6V 150:1", "N20 HP 6V 151:1", "151:1"),
        ("hopper", "kind: hopper-design", "kind: hopper-design\nlengts: 3", "lengts"),
    ],
)
def test_a_dry_run_tells_mistakes(
    kind: str, old: str, new: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = recorded_files(tmp_path)[kind]
    assert old in text
    (tmp_path / f"{kind}.yaml").write_text(text.replace(old, new))
    assert main(["hopper", str(tmp_path / f"{kind}.yaml"), "--out", str(tmp_path / "out"), "--dry-run"]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
