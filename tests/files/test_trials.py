"""Trials: their list, the content of a recording, and the common mistakes of motion data."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from synth.errors import Problem, UserError
from synth.files.csv_table import SIZE_LIMIT, read_table
from synth.files.leg_file import read_leg
from synth.files.trial_list import Trial, read_trials
from synth.swing.leg_model import Joint, Leg, Link, Spring

SHARED = Path(__file__).parents[3] / "shared"
LINK = Link(0.2, 0.7, 0.09, 3e-3)
LEG = Leg("test", (Joint("hip", LINK, math.radians(90)), Joint("knee", LINK, math.radians(180), -1)))
HEADER = "time [s],hip [deg],knee [deg]"
ROWS = [f"{i / 100:.2f},{90 + i},{150 - i}" for i in range(10)]


def csv_text(header: str = HEADER, rows: list[str] = ROWS, end: str = "\n") -> str:
    return end.join([header, *rows]) + end


def put(folder: Path, text: str | bytes, name: str = "a.csv") -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode() if isinstance(text, str) else text)


def one(folder: Path, text: str | bytes, leg: Leg = LEG) -> Trial:
    put(folder, text)
    return read_trials(["a.csv"], folder, leg)[0]


def refused(folder: Path, text: str | bytes, leg: Leg = LEG) -> list[Problem]:
    with pytest.raises(UserError) as caught:
        one(folder, text, leg)
    assert all(problem.file == "a.csv" for problem in caught.value.problems)
    return caught.value.problems


def test_reads_degrees_into_radians(tmp_path: Path) -> None:
    trial = one(tmp_path, csv_text())
    assert trial.name == "a.csv"
    assert trial.time == pytest.approx(np.arange(10) / 100)
    assert np.degrees(trial.angles) == pytest.approx(np.column_stack([90 + np.arange(10), 150 - np.arange(10)]))
    assert trial.velocities is None
    assert trial.torques is None
    assert len(trial.sha256) == 64
    with pytest.raises(ValueError, match="read-only"):
        trial.angles[0, 0] = 0.0


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + csv_text(),
        csv_text(end="\r\n"),
        csv_text('"time [s]","hip [deg]","knee [deg]"'),
        csv_text(rows=[",".join(f'"{cell}"' for cell in row.split(",")) for row in ROWS]),
        csv_text(HEADER + ",,", [row + ",," for row in ROWS]),
        csv_text(HEADER, [row + "," for row in ROWS]),
        csv_text(" time [s] , hip [deg] ,knee [ deg ]", [row.replace(",", " , ") for row in ROWS]),
        csv_text("knee [deg],time [ms],hip [rad]", [
            f"{150 - i},{10 * i},{math.radians(90 + i)!r}" for i in range(10)
        ]),
        "\n" + csv_text() + "\n\n",
        csv_text(rows=[*ROWS[:5], "", *ROWS[5:]]),
        csv_text(rows=[",,", *ROWS[:5], ",,", *ROWS[5:], ",,", ",,"]),
        csv_text(rows=[*ROWS[:5], ", ,", *ROWS[5:]]),
        csv_text().rstrip("\n"),
    ],
    ids=["bom", "crlf", "quoted header", "quoted", "trailing commas", "row commas", "blanks", "order and units",
         "blank lines", "blank within", "rows of commas", "commas and blanks",
         "no last newline"],
)  # fmt: skip
def test_spellings_of_the_same_file(tmp_path: Path, text: str) -> None:
    trial = one(tmp_path, text)
    assert trial.time == pytest.approx(np.arange(10) / 100)
    assert np.degrees(trial.angles) == pytest.approx(np.column_stack([90 + np.arange(10), 150 - np.arange(10)]))


def test_a_torque_may_be_sampled_more_densely_than_the_angles_or_at_other_times(tmp_path: Path) -> None:
    header = HEADER + ",hip torque [N*m],knee torque [N*m]"
    dense = [f"{i / 100:.3f},{90 + i},{150 - i},{i},\n{i / 100 + 0.003:.3f},,,{i + 1},\n" for i in range(12)]
    dense += [f"{i / 100 + 0.005:.3f},,,,{-i}\n" for i in range(-1, 13)]
    rows = "".join(sorted(dense, key=lambda row: float(row.split(",")[0]))).splitlines()
    rows = [row for row in "\n".join(rows).split("\n") if row]
    rows.sort(key=lambda row: float(row.split(",")[0]))
    trial = one(tmp_path, csv_text(header, [row for row in rows if float(row.split(",")[0]) >= 0]))
    assert trial.torques is not None
    assert np.isfinite(trial.torques).all()
    at = trial.time.tolist()
    assert trial.torques[at.index(0.033), 0] == pytest.approx(4.0)
    assert trial.torques[at.index(0.035), 0] == pytest.approx(4.0)  # from 4 at 33 ms to 4 at 40 ms
    assert trial.torques[at.index(0.04), 1] == pytest.approx(-3.5)
    assert trial.torques[0, 1] == pytest.approx(0.0)  # it begins half a step after the angles
    assert np.isfinite(trial.angles[:, 0]).sum() == 12


@pytest.mark.parametrize("rows", [range(20, 40), range(30), range(50, 100)])
def test_an_empty_cell_of_a_torque_does_not_mean_0(tmp_path: Path, rows: range) -> None:
    lines = [f"{i / 100:.2f},{90 + 0.1 * i},{150 - 0.1 * i},{'' if i in rows else 1}" for i in range(100)]
    (problem,) = refused(tmp_path, csv_text(HEADER + ",hip torque [N*m]", lines))
    assert "no torque is given between" in problem.text
    assert "write 0 where none acts" in problem.text
    assert problem.key == "hip torque [N*m]"
    assert problem.line == rows.start + 2


def test_missing_samples_velocities_and_torques(tmp_path: Path) -> None:
    rows = [f"{i / 100},{'' if i == 3 else 90 + i},{'NaN' if i == 0 else 150},{i},{0.1 * i}" for i in range(10)]
    trial = one(tmp_path, csv_text(HEADER + ",knee velocity [deg/s],hip torque [N*mm]", rows))
    assert np.argwhere(np.isnan(trial.angles)).tolist() == [[0, 1], [3, 0]]
    assert trial.velocities is not None
    assert np.isnan(trial.velocities[:, 0]).all()
    assert trial.velocities[:, 1] == pytest.approx(np.radians(np.arange(10)))
    assert trial.torques == pytest.approx(np.column_stack([1e-4 * np.arange(10), np.zeros(10)]))


def changed(row: int, text: str) -> str:
    rows = list(ROWS)
    rows[row] = text
    return csv_text(rows=rows)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (csv_text("time [s],hip,knee [deg]"), 1, 'column "hip" has no unit'),
        (csv_text("time [s],hip (deg),knee [deg]"), 1, "has no unit"),
        (csv_text("time [s],hip [kg],knee [deg]"), 1, "mass"),
        (csv_text("time [deg],hip [deg],knee [deg]"), 1, "time"),
        (csv_text("time [s],hip [dge],knee [deg]"), 1, "did you mean deg"),
        (csv_text("time [s],hip [deg],hip [rad]"), 1, "given twice"),
        (csv_text("hip [deg],knee [deg],Time [s]"), 1, "did you mean time"),
        (csv_text("time [s],hip [deg],kne [deg]"), 1, "did you mean knee"),
        (csv_text("time [s],hip [deg],knee velocty [deg/s]"), 1, "did you mean knee velocity"),
        ("time;hip;knee\n" + "1;2;3\n" * 9, 1, "semicolons"),
        ("time\thip\tknee\n" + "1\t2\t3\n" * 9, 1, "tabs"),
        ("# recorded today\n" + csv_text(), 1, "of a header itself remove the # alone"),
        (changed(4, "# paused"), 6, "comment"),
        (changed(4, "0.04,abc,1"), 6, '"abc" is not a number'),
        (changed(4, "0.04,1_000,1"), 6, "not a number"),
        (changed(4, "0.04,inf,1"), 6, "not a number"),
        (changed(4, "0.04,1e999,1"), 6, "not a number"),
        (changed(4, "0.04,0x10,1"), 6, "not a number"),
        (changed(4, "0.04,94"), 6, "has 2 cells"),
        (changed(4, "0.04,94,146,7"), 6, "4 cells"),
        (csv_text(rows=["0,1,90,5,150,0"] * 10), 2, "decimals take a point"),
        (changed(4, "0.02,94,146"), 6, "runs backwards: 0.03, then 0.02"),
        (changed(4, "0.03,94,146"), 6, "repeats"),
        (changed(4, ",94,146"), 6, "no time"),
        (changed(4, ",,\n,94,146\n,,"), 7, "no time"),
        (csv_text(rows=[",,"] * 9), None, "no rows"),
        (csv_text(rows=ROWS[:7]), None, "has 7 samples"),
        (csv_text(rows=[]), None, "no rows"),
        ("", None, "is empty"),
        (csv_text(rows=[row.rsplit(",", 1)[0] + "," for row in ROWS]), 1, "empty from top to bottom"),
        (csv_text("time [s],hip [rad],knee [rad]"), 2, "if these are degrees, write hip [deg] in the header"),
        (changed(4, "0.04,940,146"), 6, "940 deg is beyond any joint's travel"),
        (csv_text().encode("utf-16"), None, "UTF-16"),
        (b"PK\x03\x04 something", None, "spreadsheet"),
        (csv_text().encode() + b"\x00", 12, "zero byte"),
        (csv_text().encode() + b"\xff,1,2\n", 12, "UTF-8"),
        (csv_text(rows=[*ROWS, '"0.10,1,2']), 12, "1 cells"),
        (
            csv_text("time [s],hip [deg],knee [deg],hip torque [N*m]", [*(r + ",1" for r in ROWS), "0.2,1,2,"]),
            12,
            "torque",
        ),
    ],
)
def test_mistakes_with_their_line(tmp_path: Path, text: str | bytes, line: int | None, words: str) -> None:
    found = refused(tmp_path, text)
    assert found[0].line == line
    assert any(words in problem.text for problem in found), found


def test_missing_joint_names_the_column_that_may_be_meant(tmp_path: Path) -> None:
    found = refused(tmp_path, csv_text("time [s],hip [deg],kneee [deg]"))
    assert any('"knee [deg]" is missing; is it kneee?' in problem.text for problem in found)


def test_all_bad_cells_are_reported_up_to_a_limit(tmp_path: Path) -> None:
    found = refused(tmp_path, csv_text(rows=[f"{i},x,y" for i in range(1000)]))
    assert 20 <= len(found) <= 21
    assert (found[0].line, found[0].key) == (2, "hip [deg]")
    assert (found[1].line, found[1].key) == (2, "knee [deg]")


def radians_as_degrees(leg: Leg = LEG, offset: float = 0.0) -> str:
    time, move = np.arange(50) / 100, np.radians(20) * np.cos(np.arange(50) / 5)
    angles = leg.zero + offset + move[:, None]
    return csv_text(rows=[f"{t:.2f},{a:.5f},{b:.5f}" for t, (a, b) in zip(time, angles, strict=True)])


def test_radians_labelled_degrees(tmp_path: Path) -> None:
    found = refused(tmp_path, radians_as_degrees())
    assert "write hip [rad]" in found[0].text
    # the same numbers are small motions in degrees for a leg that hangs straight at zero
    straight = replace(LEG, joints=tuple(replace(joint, zero=0.0) for joint in LEG.joints))
    assert one(tmp_path, radians_as_degrees(), straight).angles.max() < 0.1
    # and where the leg file says that a joint lives there
    ranged = LEG.with_joints(hip={"range": (-0.1, 0.2)})
    assert one(tmp_path, radians_as_degrees(), ranged).angles.max() < 0.1
    # a spring's free angle is the better yardstick than the straight leg
    sprung = LEG.with_joints(hip={"spring": Spring(1.0, 0.02)}, knee={"spring": Spring(1.0, 0.04)})
    assert one(tmp_path, radians_as_degrees(), sprung).angles.max() < 0.1


def test_a_range_allows_many_turns(tmp_path: Path) -> None:
    ranged = LEG.with_joints(hip={"range": (-30.0, 30.0)})
    assert one(tmp_path, changed(4, "0.04,940,146"), ranged).angles[4, 0] == pytest.approx(math.radians(940))


def test_entries(tmp_path: Path) -> None:
    for name in ("t/2.csv", "t/1.csv", "heavy.csv", "odd [1].csv"):
        put(tmp_path, csv_text(), name)
    entries = [
        "t/*.csv",
        {"file": "heavy.csv", "locked": ["knee"], "tip_mass": "50 g", "tilt": "20 deg", "held_out": True},
        "odd [1].csv",
    ]
    trials = read_trials(entries, tmp_path, LEG)
    assert [trial.name for trial in trials] == ["t/1.csv", "t/2.csv", "heavy.csv", "odd [1].csv"]
    heavy = trials[2]
    assert (heavy.locked, heavy.tip_mass, heavy.held_out) == (("knee",), pytest.approx(0.05), True)
    assert heavy.tilt == pytest.approx(math.radians(20))
    assert (trials[0].locked, trials[0].tip_mass, trials[0].held_out) == ((), 0.0, False)
    assert [t.locked for t in read_trials(["t/*.csv"], tmp_path, LEG, locked=["hip"])] == [("hip",), ("hip",)]


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        (["b.csv"], "did you mean a.csv"),
        (["x/*.csv"], "matches no file"),
        (["a.csv", "a*.csv"], "listed twice (item 1 names it too)"),
        (["*.csv"], '"loop.csv", a link that leads nowhere'),
        (["a.csv", "./a.csv"], "listed twice"),
        (["../a.csv"], "leads out"),
        (["../*.csv"], ".."),
        (["/etc/passwd"], "absolute"),
        (["C:\\x.csv"], "absolute"),
        (["~/x.csv"], "absolute"),
        (["a\0.csv"], "file name"),
        (["x" * 5000], "file name"),
        ([""], "file"),
        (["."], "folder"),
        (["loop.csv"], ""),
        ([5], "not a trial"),
        ([{"locked": ["hip"]}], '"file" is missing'),
        ([{"file": "a.csv", "lockd": ["hip"]}], "did you mean locked"),
        ([{"file": "a.csv", "locked": ["hipp"]}], "did you mean hip"),
        ([{"file": "a.csv", "locked": "hip"}], "a list"),
        ([{"file": "a.csv", "locked": ["hip", "hip"]}], "named twice"),
        ([{"file": "a.csv", "locked": ["hip", "knee"]}], "every joint is locked"),
        ([{"file": "a.csv", "tip_mass": 0.05}], "has no unit"),
        ([{"file": "a.csv", "tip_mass": "-1 g"}], "at least 0"),
        ([{"file": "a.csv", "held_out": 1}], "true or false"),
    ],
)
def test_bad_entries(tmp_path: Path, entries: list[object], words: str) -> None:
    put(tmp_path, csv_text())
    (tmp_path / "loop.csv").symlink_to("loop.csv")
    with pytest.raises(UserError) as caught:
        read_trials(entries, tmp_path, LEG)  # type: ignore[arg-type]
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (50, {"trials[1].tip_mass": "50 has no unit: write it like 740 g (mass)"}),
        ("-1 g", {"trials[1].tip_mass": "-1 g is not allowed: it must be at least 0 g"}),
        ({"mass": 50}, {"trials[1].tip_mass.mass": "50 has no unit: write it like 740 g (mass)"}),
        (
            {"mass": "50 g", "inertia": "2e-6 kg*m^2", "att": "4 mm"},
            {"trials[1].tip_mass.att": '"att" is not a key here; did you mean at?'},
        ),
    ],
)
def test_a_bad_tip_mass_has_one_message_with_its_key(tmp_path: Path, written: object, said: dict[str, str]) -> None:
    put(tmp_path, csv_text())
    with pytest.raises(UserError) as caught:
        read_trials([{"file": "a.csv", "tip_mass": written}], tmp_path, LEG)
    assert {problem.key: problem.text for problem in caught.value.problems} == said


@pytest.mark.parametrize("entry", ["in.csv", "*.csv", "sub/a.csv", "sub/*.csv"])
def test_links_that_lead_out_are_refused(tmp_path: Path, entry: str) -> None:
    put(tmp_path, csv_text(), "secret/a.csv")
    project = tmp_path / "project"
    project.mkdir()
    (project / "in.csv").symlink_to(tmp_path / "secret" / "a.csv")
    (project / "sub").symlink_to(tmp_path / "secret")
    with pytest.raises(UserError, match="by a link"):
        read_trials([entry], project, LEG)


@pytest.mark.parametrize("pattern", ["t/*.csv", "*/b.csv", "**/*.csv"])
def test_a_link_that_leads_nowhere_is_named_and_not_passed_over(tmp_path: Path, pattern: str) -> None:
    put(tmp_path, csv_text(), "t/a.csv")
    put(tmp_path, csv_text(), "u/b.csv")
    (tmp_path / "t" / "b.csv").symlink_to("gone.csv")
    with pytest.raises(UserError, match=r't/b\.csv", a link that leads nowhere'):
        read_trials([pattern], tmp_path, LEG)


def test_a_folder_with_the_ending_of_a_recording_is_named_and_other_folders_are_passed_over(tmp_path: Path) -> None:
    put(tmp_path, csv_text(), "t/a.csv")
    (tmp_path / "t" / "old").mkdir()
    assert [trial.name for trial in read_trials(["t/*"], tmp_path, LEG)] == ["t/a.csv"]
    (tmp_path / "t" / "b.csv").mkdir()
    with pytest.raises(UserError, match=r't/b\.csv", which is a folder'):
        read_trials(["t/*.csv"], tmp_path, LEG)


def test_a_recording_whose_name_is_not_utf_8_is_named(tmp_path: Path) -> None:
    put(tmp_path, csv_text())
    (tmp_path / os.fsdecode(b"b\xff.csv")).write_text(csv_text())
    with pytest.raises(UserError, match="is not UTF-8") as caught:
        read_trials(["*.csv"], tmp_path, LEG)
    assert "b\\xff.csv" in str(caught.value)


def test_a_link_inside_is_followed(tmp_path: Path) -> None:
    put(tmp_path, csv_text(), "data/a.csv")
    (tmp_path / "b.csv").symlink_to("data/a.csv")
    assert read_trials(["b.csv"], tmp_path, LEG)[0].name == "b.csv"


def test_mistakes_of_all_files_at_once(tmp_path: Path) -> None:
    put(tmp_path, changed(4, "0.02,94,146"), "a.csv")
    put(tmp_path, csv_text("time [s],hip,knee [deg]"), "b.csv")
    put(tmp_path, csv_text(), "c.csv")
    with pytest.raises(UserError) as caught:
        read_trials(["*.csv", "d.csv"], tmp_path, LEG)
    assert {problem.file for problem in caught.value.problems} == {"a.csv", "b.csv", None}


def test_a_pipe_is_refused(tmp_path: Path, mkfifo: Callable[[Path], None]) -> None:
    mkfifo(tmp_path / "a.csv")
    with pytest.raises(UserError, match="not a regular file"):
        read_trials(["a.csv"], tmp_path, LEG)


@pytest.fixture
def mkfifo() -> Callable[[Path], None]:
    import os

    return lambda path: os.mkfifo(path)


def test_200_megabytes_are_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with path.open("wb") as stream:
        stream.write(csv_text().encode())
        stream.truncate(200_000_000)
    start = time.process_time()
    with pytest.raises(UserError, match="200 MB; at most 64 MB: keep every tenth row"):
        read_trials(["a.csv"], tmp_path, LEG)
    assert time.process_time() - start < 1.0


def test_too_many_rows_are_refused(tmp_path: Path) -> None:
    text = HEADER.encode() + b"\n" + b"1,2,3\n" * 2_000_100
    assert len(text) < SIZE_LIMIT
    put(tmp_path, text)
    with pytest.raises(UserError, match="more than 2000000 rows"):
        read_table(tmp_path / "a.csv")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the lab's data lie outside the repository")
def test_real_recordings() -> None:
    rat = SHARED / "aarl" / "rat"
    trials = read_trials(["releases/*.csv", "recordings/*.csv"], rat, read_leg(rat / "rat.leg.yaml"))
    assert len(trials) == 65
    dog = SHARED / "aarl" / "dog"
    assert len(read_trials(["damper_drops/*.csv"], dog, read_leg(dog / "dog_dampers.leg.yaml"))) == 24
    assert len(read_trials(["joint_tests/*.csv"], dog, read_leg(dog / "dog_built.leg.yaml"))) == 36
    first = next(trial for trial in trials if trial.name == "releases/IP_5.csv")
    assert np.degrees(first.angles[0]) == pytest.approx([94.2190, 140.3925, 150.4109])


def several(folder: Path, change: Callable[[np.ndarray], np.ndarray]) -> list[Problem]:
    """What is wrong with four recordings, of which one was changed."""
    for k in range(4):
        values = np.column_stack([np.arange(60) * 1e-3, np.full(60, 95.0 + k), np.full(60, 150.0 - 2 * k)])
        values[:, 1:] += np.linspace(0, 20, 60)[:, None]
        values = change(values) if k == 1 else values
        rows = [",".join(f"{cell:.6g}" for cell in row) for row in values]
        put(folder, csv_text(rows=rows), f"{k}.csv")
    try:
        read_trials(["*.csv"], folder, LEG)
    except UserError as error:
        return error.problems
    return []


def test_one_recording_in_milliseconds_or_with_exchanged_columns_is_named(tmp_path: Path) -> None:
    assert several(tmp_path, lambda values: values) == []
    (slow,) = several(tmp_path, lambda values: values * [1000.0, 1.0, 1.0])
    assert (slow.file, slow.key) == ("1.csv", "time [s]")
    (slow,) = several(tmp_path, lambda values: values * [200.0, 1.0, 1.0])
    assert slow.file == "1.csv"
    assert "200 times the step of the other recordings (0.001 s)" in slow.text
    (swapped,) = several(tmp_path, lambda values: values[:, [0, 2, 1]])
    assert swapped.file == "1.csv"
    assert "the columns of hip and knee look exchanged" in swapped.text


@pytest.mark.parametrize(
    ("slower", "step", "unit"),
    [
        (1e-3, "1000 times less than the step of the other recordings (0.001 s), and its motion is ",
         "With one 1000 times larger in its header, such as [s] for [ms], they would be 0.001 s apart"),
        (200.0, "200 times the step of the other recordings (0.001 s), and its motion is ",
         "With one 60 times smaller in its header, such as [s] for [min], they would be 0.00333 s apart"),
    ],
)  # fmt: skip
def test_the_unit_that_makes_the_clocks_agree_is_named(tmp_path: Path, slower: float, step: str, unit: str) -> None:
    (problem,) = several(tmp_path, lambda values: values * [slower, 1.0, 1.0])
    assert step in problem.text
    assert problem.text.endswith(f"Is the time in another unit? {unit}")


def swings(folder: Path, name: str, step: float, wrong: float = 1.0, amplitude: float = 20.0) -> None:
    """A swing of 2 Hz in 2 s with 0.05 deg of noise, ``step`` s apart, its clock ``wrong`` times too slow."""
    time = np.arange(0.0, 2.0, step)
    angles = np.outer(np.exp(-time) * np.cos(4.0 * np.pi * time), [amplitude, -0.5 * amplitude])
    angles += np.random.default_rng(len(time)).normal([90.0, 150.0], 0.05, angles.shape)
    rows = [f"{wrong * t:.12g},{hip:.6g},{knee:.6g}" for t, (hip, knee) in zip(time, angles, strict=True)]
    put(folder, csv_text(rows=rows), name)


@pytest.mark.parametrize("steps", [(1 / 30, 1e-4), (0.05, 1e-4, 1e-4), (1e-4, 1 / 30, 1 / 30), (0.05, 5e-5)])
def test_a_camera_and_a_fast_encoder_that_saw_the_same_swing_are_read_together(
    tmp_path: Path, steps: tuple[float, ...]
) -> None:
    for k, step in enumerate(steps):
        swings(tmp_path, f"{k}.csv", step)
    assert len(read_trials(["*.csv"], tmp_path, LEG)) == len(steps)


@pytest.mark.parametrize(
    ("step", "wrong", "said"),
    [
        (1e-4, 1e3, "times as slow as theirs. Is the time in another unit? With one 1000 times smaller in its header"),
        (2e-3, 60.0, "times as slow as theirs. Is the time in another unit? With one 60 times smaller in its header"),
        (5e-3, 1e-3, "times as fast as theirs. Is the time in another unit? With one 1000 times larger in its header"),
    ],
)
def test_a_swing_in_another_unit_of_time_is_refused_at_other_rates_too(
    tmp_path: Path, step: float, wrong: float, said: str
) -> None:
    for k in range(3):
        swings(tmp_path, f"{k}.csv", 1e-3)
    swings(tmp_path, "other.csv", step, wrong)
    with pytest.raises(UserError) as caught:
        read_trials(["*.csv"], tmp_path, LEG)
    (problem,) = caught.value.problems
    assert problem.file == "other.csv"
    assert said in problem.text


def test_at_very_different_rates_a_recording_without_motion_is_refused_with_the_way_out(tmp_path: Path) -> None:
    swings(tmp_path, "camera.csv", 1 / 30)
    swings(tmp_path, "still.csv", 1e-4, amplitude=0.0)
    with pytest.raises(
        UserError, match="If it is, leave out rows of the denser recordings, until the steps differ less"
    ):
        read_trials(["*.csv"], tmp_path, LEG)


@pytest.mark.parametrize(
    ("written", "step", "said"),
    [
        ("s", 7.5, ": with time [ms] they would be 0.0075 s apart"),
        ("s", 5e6, ": with time [ns] they would be 0.005 s apart"),
        ("ns", 0.01, ": with time [s] they would be 0.01 s apart"),
        ("s", 1e-9, "Then say so in the header"),
    ],
)
def test_the_unit_of_a_clock_that_no_recorder_has(tmp_path: Path, written: str, step: float, said: str) -> None:
    rows = [f"{i * step:.12g},{90 + i},{150 - i}" for i in range(10)]
    (problem,) = refused(tmp_path, csv_text(f"time [{written}],hip [deg],knee [deg]", rows=rows))
    assert problem.text.endswith(said)


def test_angles_that_only_lie_elsewhere_are_no_mistake(tmp_path: Path) -> None:
    assert several(tmp_path, lambda values: values + np.array([0.0, 30.0, 0.0])) == []


@pytest.mark.parametrize("factor", [1e-9, 1e-6, 1e3])
def test_a_clock_that_no_recorder_has_is_refused(tmp_path: Path, factor: float) -> None:
    rows = [f"{i * 0.01 * factor:.12g},{90 + i},{150 - i}" for i in range(10)]
    (problem,) = refused(tmp_path, csv_text(rows=rows))
    assert "Is the time in another unit?" in problem.text
    assert problem.key == "time [s]"


def test_a_tilted_leg_that_rests_elsewhere_has_its_columns_in_order(tmp_path: Path) -> None:
    """Three alike at (90, 78) deg; one tilted rests at (79, 95), which is nearer to them with the columns exchanged."""
    for k in range(4):
        rest = (79.0, 95.0) if k == 3 else (90.0 + 0.1 * k, 78.0)
        values = np.column_stack([np.arange(60) * 1e-3, *[angle + np.linspace(-2, 2, 60) for angle in rest]])
        put(tmp_path, csv_text(rows=[",".join(f"{cell:.6g}" for cell in row) for row in values]), f"{k}.csv")
    listed: list[dict[str, object]] = [{"file": f"{k}.csv"} for k in range(4)]
    with pytest.raises(UserError, match="look exchanged"):
        read_trials(listed, tmp_path, LEG)
    listed[3]["tilt"] = "40 deg"
    assert len(read_trials(listed, tmp_path, LEG)) == 4


@pytest.mark.parametrize("unit", ["deg", "rad"])
def test_an_angle_beyond_a_stated_range_is_told_with_that_range(tmp_path: Path, unit: str) -> None:
    """A pendulum that turns on for many turns: the range has to be widened, the unit is right."""
    turning = LEG.with_joints(hip={"range": (math.radians(-720), math.radians(720))})
    value = 760.0 if unit == "deg" else math.radians(760.0)
    rows = [f"{i / 100:.2f},{0.1 * i},0.5" for i in range(9)]
    (found,) = refused(tmp_path, csv_text(f"time [s],hip [{unit}],knee [rad]", [*rows, f"0.2,{value!r},0.5"]), turning)
    assert "760 deg" in found.text
    assert "outside the joint's range in the leg file, -720 to 720 deg" in found.text


@pytest.mark.parametrize("surplus", ["NaN", "nan", " nan "])
def test_a_cell_beyond_the_header_is_refused_though_it_says_nan(surplus: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"time [s],hip [deg]\n0,1,\n1,5,{surplus}\n")
    with pytest.raises(UserError, match=r"a\.csv:3: has 3 cells where the header has 2 columns"):
        read_table(tmp_path / "a.csv")
    (tmp_path / "a.csv").write_text("time [s],hip [deg]\n0,1,\n1,nan, \n2,5,\n")
    np.testing.assert_array_equal(read_table(tmp_path / "a.csv").values, [[0, 1], [1, np.nan], [2, 5]])
