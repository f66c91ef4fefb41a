"""Clocks that count from 1970 or from a machine's start: read and written without loss of their digits."""

from __future__ import annotations

import json
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from synth.cli import main
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.files.leg_file import read_leg
from synth.files.log_clock import log_clock
from synth.files.recording import Recorded, read_recording
from synth.motion.importers.convert import ImportedRecording, import_file

STEPS = np.cumsum(np.tile([16_666_667, 16_666_666, 16_700_001], 40)) - 16_666_667  # ns after the first sample
EPOCH = 1_700_000_000_123_456_789  # ns
UNITS = {"s": 9, "ms": 6, "us": 3, "ns": 0}
LEG = """kind: leg
name: arm
joints:
  - {name: knee, zero: 180 deg, sign: +1, link: {length: 0.2 m, mass: 0.2 kg, com: 0.08 m, inertia: 1e-3 kg*m^2}}
"""
DRIVE = "drive: {kind: servo, gain: 2 1/rad, supply: 12 V, motor: {resistance: 3 ohm, torque_constant: 0.4 N*m/A}}"
ANGLE = 140.0 + 20.0 * np.cos(9e-9 * STEPS)


def stamps(unit: str, start: int = EPOCH) -> list[str]:
    """The times as a logger writes them, with all digits to the nanosecond."""
    scale = 10 ** UNITS[unit]
    return [str(t) if scale == 1 else f"{t // scale}.{t % scale:0{UNITS[unit]}d}" for t in (start + STEPS).tolist()]


def leg_file(folder: Path, drive: str = "") -> Path:
    path = folder / "arm.leg.yaml"
    path.write_text(LEG.replace("}}\n", f"}},\n     {drive}}}\n") if drive else LEG)
    return path


def read(path: Path, mapping: Mapping | None = None, **options: object) -> ImportedRecording:
    mapping = mapping or Mapping()
    leg = read_leg(leg_file(path.parent))
    return import_file(path, leg, mapping, name=path.name, **({"cut": "keep"} | options))  # type: ignore[arg-type]


def write_table(path: Path, unit: str, start: int = EPOCH) -> None:
    rows = (f"{t},{a:.6f}" for t, a in zip(stamps(unit, start), ANGLE, strict=True))
    path.write_text("\n".join([f"time [{unit}],knee [deg]", *rows]) + "\n")


def trial_written(folder: Path, source: Path) -> Recorded:
    assert main(["--quiet", "import", str(source), "--leg", str(leg_file(folder)), "--out", str(folder / "out")]) == 0
    return read_recording(next((folder / "out" / "trials").iterdir()), read_leg(leg_file(folder)))


@pytest.mark.parametrize("unit", list(UNITS))
def test_unix_time_is_read_and_written_to_the_nanosecond(tmp_path: Path, unit: str) -> None:
    write_table(tmp_path / "log.csv", unit)
    found = trial_written(tmp_path, tmp_path / "log.csv")
    np.testing.assert_allclose(found.time, 1e-9 * STEPS, atol=1e-9, rtol=0.0)
    notes = json.loads((tmp_path / "out" / "import.json").read_text())["trials"][0]["notes"]
    assert notes[0] == "the clock begins at 1700000000.123457 s, set to 0"


def test_a_trial_is_read_from_the_same_zero_without_an_import(tmp_path: Path) -> None:
    write_table(tmp_path / "log.csv", "ns")
    found = read_recording(tmp_path / "log.csv", read_leg(leg_file(tmp_path)))
    np.testing.assert_allclose(found.time, 1e-9 * STEPS, atol=1e-12, rtol=0.0)


def test_a_time_that_repeats_is_shown_with_all_its_digits(tmp_path: Path) -> None:
    write_table(tmp_path / "log.csv", "us")
    lines = (tmp_path / "log.csv").read_text().splitlines()
    lines[3] = f"{lines[2].partition(',')[0]},{lines[3].partition(',')[2]}"
    (tmp_path / "log.csv").write_text("\n".join(lines))
    with pytest.raises(UserError, match=r"log.csv:4: time \[us\]: time repeats: 1700000000140123.5, then 1700"):
        read_recording(tmp_path / "log.csv", read_leg(leg_file(tmp_path)))


def test_uptime_is_rebased_and_a_clock_of_some_hours_kept(tmp_path: Path) -> None:
    for start, begins in ((12_345_678, 0.0), (9_000, 9_000.0)):
        write_table(tmp_path / "log.csv", "s", start * 1_000_000_000)
        found = trial_written(tmp_path, tmp_path / "log.csv")
        np.testing.assert_allclose(found.time, begins + 1e-9 * STEPS, atol=1e-9, rtol=0.0)


def test_json_and_matlab_numbers_keep_their_digits(tmp_path: Path) -> None:
    moments = EPOCH + STEPS
    records = [{"time [ns]": t, "knee [deg]": a} for t, a in zip(moments.tolist(), ANGLE, strict=True)]
    (tmp_path / "log.json").write_text(json.dumps(records))
    scipy.io.savemat(tmp_path / "log.mat", {"t": moments, "knee": ANGLE})
    seconds = [{"time [s]": 1.7e9 + k / 1000, "knee [deg]": a} for k, a in enumerate(ANGLE.tolist())]
    (tmp_path / "seconds.json").write_text(json.dumps(seconds))
    np.testing.assert_allclose(read(tmp_path / "seconds.json").time, 1e-3 * np.arange(len(ANGLE)), atol=1e-12, rtol=0.0)
    by_name = Mapping(time="t", time_unit="ns", joints={"knee": JointColumn("knee", "deg")})
    for name, mapping in (("log.json", Mapping()), ("log.mat", by_name)):
        found = read(tmp_path / name, mapping)
        np.testing.assert_allclose(found.time, 1e-9 * STEPS, atol=1e-12, rtol=0.0)
        assert found.notes[0].startswith("the clock begins at 1700000000.12345")


def test_a_window_counts_on_the_files_own_clock(tmp_path: Path) -> None:
    write_table(tmp_path / "log.csv", "ms")
    begin = 1e-9 * EPOCH
    found = read(tmp_path / "log.csv", window=(begin + 0.5, begin + 1.5))
    assert 0.5 - 1e-6 <= found.time[0] < 0.52
    assert 1.48 < found.time[-1] <= 1.5 + 1e-6
    with pytest.raises(UserError, match=r"0.5 to 1.5 s holds 0 samples of the file's 1700000000.12\d* to 1700000002"):
        read(tmp_path / "log.csv", window=(0.5, 1.5))


def test_commands_of_another_rate_keep_their_place_beside_the_angles(tmp_path: Path) -> None:
    """Rows of the command between those of the angle, on one Unix clock."""
    leg_file(tmp_path, DRIVE)
    lines = ["time [s],knee [deg],knee command [deg]"]
    for k, (t, a) in enumerate(zip(STEPS.tolist(), ANGLE, strict=True)):
        for moment, angle, command in ((t, f"{a:.6f}", ""), (t + 5_000_000, "", f"{150 + k % 7}")):
            whole, left = divmod(EPOCH + moment, 10**9)
            lines.append(f"{whole}.{left:09d},{angle},{command}")
    lines[1] += "150"
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    target = str(tmp_path / "out")
    assert main(["--quiet", "import", str(tmp_path / "log.csv"), "--leg", str(tmp_path / "arm.leg.yaml"),
                 "--release", "keep", "--out", target]) == 0  # fmt: skip
    path, leg = next((tmp_path / "out" / "trials").iterdir()), read_leg(tmp_path / "arm.leg.yaml")
    for source in (path, tmp_path / "log.csv"):  # as imported, and as a trial by itself
        found = read_recording(source, leg)
        assert found.signals is not None
        seen = np.isfinite(found.angles[:, 0])
        np.testing.assert_allclose(found.time[seen], 1e-9 * STEPS, atol=1e-9, rtol=0.0)
        moments = 1e-9 * (STEPS + 5_000_000)
        at = np.searchsorted(found.signals.time, moments + 1e-6) - 1
        np.testing.assert_allclose(found.signals.time[at], moments, atol=1e-9, rtol=0.0)
        np.testing.assert_allclose(np.degrees(found.signals.command[at, 0]), 150 + np.arange(len(STEPS)) % 7, atol=1e-6)


def test_the_cut_to_the_release_keeps_the_steps(tmp_path: Path) -> None:
    """A second at rest, then a swing: what is left begins at the release, one sample's step after the other."""
    time = np.arange(500) / 250.0
    swing = np.where(time < 1.0, 0.0, time - 1.0)
    angle = 180.0 + 30.0 * np.exp(-2.0 * swing) * np.cos(9.0 * swing)
    for begin in (0, 1_700_000_000):
        rows = (f"{begin + k // 250}.{4 * (k % 250):03d},{a:.5f}" for k, a in enumerate(angle))
        (tmp_path / f"{begin}.csv").write_text("\n".join(["time [s],knee [deg]", *rows]))
    near, far = (read(tmp_path / f"{begin}.csv", cut="cut") for begin in (0, 1_700_000_000))
    assert near.time[0] > 0.9
    np.testing.assert_allclose(far.time, near.time, atol=1e-9, rtol=0.0)
    assert far.notes[1:] == near.notes


def test_a_robots_stamps_keep_their_nanoseconds(tmp_path: Path) -> None:
    writer = pytest.importorskip("mcap.writer").Writer
    with (tmp_path / "run.mcap").open("wb") as stream:
        log = writer(stream)
        log.start()
        schema = log.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        channel = log.register_channel("/joint_states", "json", schema)
        for t, a in zip((EPOCH + STEPS).tolist(), np.radians(ANGLE).tolist(), strict=True):
            head = {"stamp": {"sec": t // 10**9, "nanosec": t % 10**9}}
            data = json.dumps({"header": head, "name": ["knee"], "position": [a]}).encode()
            log.add_message(channel, log_time=t + 2_000_000, publish_time=0, data=data)
        log.finish()
    found = read(tmp_path / "run.mcap")
    np.testing.assert_allclose(found.time, 1e-9 * STEPS, atol=1e-12, rtol=0.0)
    assert found.notes[:2] == (
        "the clock begins at 1700000000.123457 s, set to 0",
        "joint states of /joint_states",
    )


def test_even_steps_that_doubles_rounded_are_even_again() -> None:
    """As Unix seconds a double holds 2.4e-7 s: steps of 1 ms came out 0.9999275 and 1.0001659 ms long."""
    even = np.arange(2000) * 1e-3
    lost = np.delete(even, [17, 18, 903])
    for wanted in (even, lost):
        stamps = 1.7e9 + 0.123 + wanted
        assert np.ptp(np.diff(stamps)) > 2e-7
        clock = log_clock(stamps, 1.0, stamps.tolist)
        np.testing.assert_allclose(clock.time, wanted, rtol=0.0, atol=1e-12)
        assert clock.even == 1e-3
        assert "hold such times to 2.4e-07 s only; its steps are multiples of 0.001 s" in clock.notes[1]


def test_a_jittering_clock_of_doubles_is_kept_and_its_rounding_told() -> None:
    jitter = np.arange(500) * 1e-3 + np.random.default_rng(1).normal(0.0, 2e-6, 500)
    stamps = 1.7e9 + jitter
    clock = log_clock(stamps, 1.0, stamps.tolist)
    np.testing.assert_array_equal(clock.time, stamps - stamps[0])
    assert clock.notes[1] == (
        "the file's numbers hold such times to 2.4e-07 s only, so much of its unevenness may be rounding"
    )
    exact = [Decimal(1_700_000_000) + Decimal(f"{value:.9f}") for value in jitter]
    assert len(log_clock(stamps, 1.0, lambda: exact).notes) == 1
    assert log_clock(stamps - 1.7e9, 1.0).notes == ()
