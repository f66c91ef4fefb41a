"""``synth import`` end to end: from a foreign file to trials that ``synth fit`` reads."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import bare
from motion.driven_releases import driven_release
from motion.importers.simulated_leg import PARTS, angles, leg, pixels, points
from motion.importers.test_deeplabcut import parts, written
from page_reader import page_of
from result_fields import require_explained
from synth.cli import main
from synth.commands import init
from synth.files.leg_file import read_leg, write_leg
from synth.files.recording import read_recording
from synth.reports import stick_figure
from synth.reports.reading import Result
from synth.reports.section import AbsentResult

LEG = "leg.leg.yaml"
DATA = Path(__file__).resolve().parents[1] / "motion" / "importers" / "data"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two tracked videos, one filmed from the other side and cut by hand, and a project for both."""
    monkeypatch.chdir(tmp_path)
    write_leg(bare(leg()), tmp_path / LEG)
    (tmp_path / "videos").mkdir()
    generator = np.random.default_rng(1)
    places = points(angles()[1])
    for name, factor in (("a.csv", 1), ("b.csv", -1)):
        noise = generator.normal(0, 0.2, places.shape)
        written(tmp_path / "videos" / name, parts(pixels(places * [factor, 1]) + noise))
    text = f"kind: import\nleg: {LEG}\nfiles: [videos/a.csv, {{file: videos/b.csv, window: [0.55 s, 1.4 s]}}]\n"
    text += f"points: [{', '.join(PARTS)}]\nframe_rate: 200 Hz\n"
    (tmp_path / "import.yaml").write_text(text)
    return tmp_path


def test_an_import_project_writes_trials_page_and_report(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "import.yaml", "--out", "out"]) == 0
    said = capsys.readouterr().out
    assert "videos/a.csv: " in said
    assert re.search(r"cut at the release: \d+ of 300 samples, up to 0\.\d+ s, left out", said)
    assert "cut to the window given: 129 of 300 samples left out" in said
    assert "knee: 100% of the samples lie outside its range [60, 175] deg; with the other sign" in said
    recorded = read_recording(project / "out" / "trials" / "a.csv", read_leg(project / LEG))
    at = np.searchsorted(angles()[0], recorded.time - 1e-9)
    assert 95 < at[0] < 106
    np.testing.assert_allclose(np.degrees(recorded.angles), angles()[1][at], atol=0.5)
    account = json.loads((project / "out" / "import.json").read_text())
    assert account["format"] == "synth/import/1"
    one, other = account["trials"]
    assert (one["source"], one["file"], one["source_format"]) == ("videos/a.csv", "trials/a.csv", "deeplabcut")
    assert one["rate"] == {"value": 200.0, "unit": "Hz"}
    assert one["release"]["released"]["value"] == pytest.approx(0.5, abs=0.02)
    assert one["samples"] == len(recorded.time)
    assert "release" not in other
    page = (project / "out" / "report.html").read_text()
    assert page.count("the leg as a stick figure</title>") == 1 + 2  # the opening shows the first
    assert "with the other sign they would be inside" in page
    assert "hip 125° ↺" in page
    assert re.search("ankle 16[0-9]° ↻", page)


def test_the_printed_command_runs_also_with_blanks(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "import.yaml", "--out", "my out/trials of today"]) == 0
    (line,) = [each for each in capsys.readouterr().out.splitlines() if "fit them with: " in each]
    words = shlex.split(line.partition("fit them with: ")[2])
    assert words == ["synth", "fit", "my out/trials of today/fit.yaml", "--out", "trials of today_fit"]
    assert main([*words[1:], "--dry-run"]) == 0


def test_a_fit_does_not_replace_the_import_that_it_reads(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(project / "import.yaml"), "--out", str(project / "found")]) == 0
    before = sorted(path.name for path in (project / "found").rglob("*"))
    capsys.readouterr()
    assert main(["fit", str(project / "found" / "fit.yaml"), "--out", str(project / "found")]) == 2
    assert "holds what this run reads (fit.yaml, leg.leg.yaml" in capsys.readouterr().err
    assert sorted(path.name for path in (project / "found").rglob("*")) == before


def test_a_mirrored_video_gives_the_same_angles(project: Path) -> None:
    text = (project / "import.yaml").read_text().replace("videos/a.csv, ", "")
    (project / "import.yaml").write_text(text + "mirror: true\n")
    assert main(["--quiet", "import", "import.yaml", "--out", "out"]) == 0
    recorded = read_recording(project / "out" / "trials" / "b.csv", read_leg(project / LEG))
    np.testing.assert_allclose(np.degrees(recorded.angles), angles()[1][110:281], atol=0.9)


def test_imports_are_repeatable_and_a_dry_run_writes_nothing(project: Path) -> None:
    for out in ("one", "two"):
        assert main(["--quiet", "import", "import.yaml", "--out", out]) == 0
    for file in ("import.json", "report.html", "trials/a.csv"):
        assert (project / "one" / file).read_bytes() == (project / "two" / file).read_bytes()
    assert main(["--quiet", "import", "import.yaml", "--out", "three", "--dry-run"]) == 0
    assert not (project / "three").exists()


def test_a_dry_run_as_json_is_the_run_s_own(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    documents = []
    for end in (["--out", "out"], ["--dry-run"]):
        assert main(["--quiet", "import", "import.yaml", *end, "--json"]) == 0
        documents.append(json.loads(capsys.readouterr().out))
    assert documents[0] == documents[1]


def test_a_single_recording_is_imported(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["import", "videos/a.csv", "--leg", LEG, "--out", "out", "--points", "hip,knee,ankle,toe"]
    assert main([*words, "--frame-rate", "200 Hz", "--release", "keep"]) == 0
    assert "nothing was cut, as wished" in capsys.readouterr().out
    assert len((project / "out" / "trials" / "a.csv").read_text().splitlines()) == 301


def test_a_log_of_foreign_columns_says_where_they_are_assigned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bench's own names: the message holds the project that reads the log, with the command's column."""
    monkeypatch.chdir(tmp_path)
    link = "link: {length: 0.1 m, mass: 0.49 kg, com: 0.1 m, inertia: 1e-4 kg*m^2}"
    drive = "drive: {kind: servo, gain: 1 N*m/rad}"
    Path("arm.leg.yaml").write_text(
        f"kind: leg\nname: arm\njoints:\n  - {{name: arm, zero: 0 deg, sign: +1, {link}, {drive}}}\n"
    )
    rows = [f"{0.3 * np.sin(0.05 * k):.6f},{0.005 * k},{0.3 * np.sin(0.05 * k + 0.1):.6f}" for k in range(200)]
    Path("log.csv").write_text("\n".join(["position,timestamp,goal_position", *rows]) + "\n")
    assert main(["--quiet", "import", "log.csv", "--leg", "arm.leg.yaml", "--out", "out"]) == 2
    said = capsys.readouterr().err
    assert "files: [log.csv], joints: {arm: {column: COLUMN}}; beside it `unit: deg`" in said
    assert "`command: COLUMN`" in said
    project = "kind: import\nleg: arm.leg.yaml\nfiles: [log.csv]\ntime: {column: timestamp, unit: s}\n"
    Path("log.yaml").write_text(project + "joints: {arm: {column: position, unit: rad, command: goal_position}}\n")
    assert main(["--quiet", "import", "log.yaml", "--out", "out"]) == 0
    assert "arm command" in (tmp_path / "out" / "trials" / "log.csv").read_text().partition("\n")[0]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "synth gap gap.yaml --out gap" in page  # a driven leg is diagnosed, not fitted
    (drawn,) = [
        block for block in re.findall(r"<script type=.application/json.>(.*?)</script>", page) if "curves" in block
    ]
    told, read = json.loads(drawn)["curves"]
    assert (told["name"], read["name"]) == ("command", "measured")
    np.testing.assert_allclose(
        np.radians(told["values"]), [0.3 * np.sin(0.05 * k + 0.1) for k in range(200)], atol=1e-4
    )


def test_rows_of_commands_alone_do_not_break_the_lines_of_the_page(tmp_path: Path) -> None:
    """Commands of another topic have rows of their own; each is drawn as held, the angles as joined."""
    arm = {"joints": [{"name": "arm", "zero": {"value": 0.0, "unit": "deg"}, "sign": 1,
                       "length": {"value": 100.0, "unit": "mm"}}]}  # fmt: skip
    (tmp_path / "log.csv").write_text("time [s],arm [deg],arm command [deg]\n0,1,\n0.1,,5\n0.2,2,\n0.3,,6\n0.4,3,7\n")
    shown = stick_figure.content(Result(tmp_path, "import.json", {"leg": arm, "trials": [{"file": "log.csv"}]}))
    assert not isinstance(shown, AbsentResult)
    (block,) = re.findall(r"<script type=.application/json.>(.*?)</script>", str(shown["trials"][0]["angles"]))
    drawn = json.loads(block)
    assert drawn["time"] == [0.0, 0.2, 0.4]
    assert [curve["values"] for curve in drawn["curves"]] == [[None, 5.0, 7.0], [1.0, 2.0, 3.0]]


def test_a_slow_release_is_cut_and_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A hand that lets go over 0.15 s, cut away by `release: free`: what is left is fitted to 5 %."""
    generator = np.random.default_rng(8)
    made = [driven_release(generator, 0.15, 0.05) for _ in range(1)]
    truth = made[0].leg
    write_leg(bare(truth), tmp_path / LEG)
    table = np.column_stack([made[0].time, np.degrees(made[0].angles)])
    header = "seconds,Hip (deg),Knee (deg),Ankle (deg)"
    np.savetxt(tmp_path / "logger.csv", table, delimiter=",", header=header, comments="", fmt="%.5f")
    text = f"kind: import\nleg: {LEG}\nfiles: [logger.csv]\ntime: {{column: seconds, unit: s}}\nrelease: free\n"
    (tmp_path / "import.yaml").write_text(text)
    assert main(["import", str(tmp_path / "import.yaml"), "--out", str(tmp_path / "out")]) == 0
    assert "cut at the end of the external torque" in capsys.readouterr().out
    first = float((tmp_path / "out" / "trials" / "logger.csv").read_text().splitlines()[1].split(",")[0])
    assert made[0].free_from - 0.06 < first < made[0].free_from + 0.04
    shutil.copytree(tmp_path / "out" / "trials", tmp_path / "trials")
    (tmp_path / "fit.yaml").write_text(f"kind: fit\nleg: {LEG}\ntrials: [trials/*.csv]\n")
    assert main(["--quiet", "fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "fitted")]) == 0
    fit = json.loads((tmp_path / "fitted" / "fit.json").read_text())
    for joint in truth.joints:
        assert joint.spring is not None
        found = fit["joints"][joint.name]["spring_rate"]["value"]
        assert found == pytest.approx(joint.spring.rate, rel=0.05)


def test_files_of_one_name_in_two_folders_get_distinct_names(project: Path) -> None:
    (project / "more").mkdir()
    shutil.copy(project / "videos" / "a.csv", project / "more" / "a.csv")
    text = (project / "import.yaml").read_text()
    (project / "import.yaml").write_text(re.sub("files: .*", "files: [videos/a.csv, more/a.csv]", text))
    assert main(["--quiet", "import", "import.yaml", "--out", "out"]) == 0
    assert sorted(path.name for path in (project / "out" / "trials").iterdir()) == [
        "more_a.csv",
        "videos_a.csv",
    ]


def test_files_of_a_glob_are_left_out_by_name(project: Path) -> None:
    """One whose joint has too few samples stopped the import of all."""
    text = (project / "import.yaml").read_text()
    excluded = "files: [videos/*.csv]\nexclude: [videos/b.csv]"
    (project / "import.yaml").write_text(re.sub("files: .*", excluded, text))
    assert main(["--quiet", "import", "import.yaml", "--out", "out"]) == 0
    assert [path.name for path in (project / "out" / "trials").iterdir()] == ["a.csv"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("points:", "pionts:", r'import.yaml:4: pionts: "pionts" is not a key here; did you mean points\?'),
        ("200 Hz", "200", r"import.yaml:5: frame_rate: 200 has no unit: write it like 10 Hz"),
        ("kind: import", "kind: fit", r'import.yaml:1: kind: a file of kind fit is read by "synth fit"'),
        ("0.55 s, 1.4 s", "1.4 s, 0.55 s", r"files\[2\].window: the window must go from the earlier time to the later"),
        ("videos/b.csv", "videos/c.csv", r"import.yaml:3: files\[2\]: .*c.csv.* does not exist"),
        ("frame_rate: 200 Hz", "joints: {hop: x}", r'joints.hop: "hop" is no joint of robot; did you mean hip\?'),
        ("frame_rate: 200 Hz", "release: start", r'release: "start" is not allowed; allowed here: cut, free, keep'),
        (
            "frame_rate: 200 Hz",
            "joints: {hip: {column: x, unit: mm}}",
            r"joints.hip.unit: \[mm\] is the unit of a leng",
        ),
        ("frame_rate", "time: {column: t}\nframe_rate", r'"time" and "frame_rate" are both given; keep one'),
        ("frame_rate", "exclude: [videos/c.csv]\nframe_rate", r"import.yaml:5: exclude\[1\]: .*c.csv.* does not exist"),
        ("frame_rate", f"exclude: [{LEG}]\nframe_rate", r'exclude\[1\]: "leg.leg.yaml" is not among "files"'),
        ("frame_rate", "exclude: [videos/*.csv]\nframe_rate", r"import.yaml:5: exclude: leaves out all files"),
        ("frame_rate: 200 Hz", "", r"videos/a.csv: has no clock: state the camera's frame rate"),
    ],
)
def test_mistakes_in_the_import_project_are_reported(
    project: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    text = (project / "import.yaml").read_text()
    assert old in text
    (project / "import.yaml").write_text(text.replace(old, new, 1))
    assert main(["--quiet", "import", "import.yaml", "--out", "out"]) == 2
    assert re.search(message, capsys.readouterr().err)
    assert not (project / "out").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["import.yaml", "--leg", LEG], r"--leg: applies to recordings; import.yaml is a project"),
        (["videos/a.csv"], r"videos/a.csv: name the leg whose joints were recorded: --leg LEG.leg.yaml"),
        (["videos/a.csv", "--leg", LEG, "--plane", "x"], r'--plane: "x": write two axes, such as x,z'),
        (["videos/a.csv", "--leg", LEG, "--frame-rate", "200"], r'--frame-rate: "200" has no unit'),
        (["videos/a.csv", "--leg", LEG, "--release", "now"], r'--release: "now" is not one of cut, free, keep'),
        (["none.mot", "--leg", LEG], r"none.mot: does not exist"),
        ([str(DATA / "unsaid.sto"), "--leg", LEG], r"unsaid.sto: inDegrees: its header does not state inDegrees"),
        (["film.mp4", "--leg", LEG], r"film.mp4: does not exist"),
    ],
)
def test_mistakes_on_the_import_command_line_are_reported(
    project: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert main(["--quiet", "import", *words, "--out", "out"]) == 2
    assert re.search(message, capsys.readouterr().err)


def test_angles_beyond_any_travel_are_refused_by_the_name_of_the_source(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Degrees labelled radians: detected when the written trial is read like in a fit."""
    time, measured = angles()
    table = np.column_stack([time, measured])
    np.savetxt(project / "x.csv", table, delimiter=",", header="time (s),hip,knee,ankle", comments="")
    columns = ", ".join(f"{name}: {{column: {name}, unit: rad}}" for name in ("hip", "knee", "ankle"))
    (project / "x.yaml").write_text(f"kind: import\nleg: {LEG}\nfiles: [x.csv]\njoints: {{{columns}}}\nrelease: keep\n")
    for end in (["--out", "out"], ["--dry-run"]):
        assert main(["--quiet", "import", "x.yaml", *end]) == 2
        assert "x.csv (as trials/x.csv)" in capsys.readouterr().err


def test_missing_readings_are_not_among_the_samples_kept(tmp_path: Path) -> None:
    """All "480 of 480 samples kept" stood over a trial of which the ankle lacks 4."""
    example = Path(init.__file__).resolve().parent.parent / "examples" / "import"
    assert main(["--quiet", "import", str(example / "import.yaml"), "--out", str(tmp_path / "out")]) == 0
    content = json.loads((tmp_path / "out" / "import.json").read_text())
    assert [trial["missing"] for trial in content["trials"]] == [{"ankle": 4}, {}]
    require_explained("import.json", content)
    _, page = page_of(tmp_path / "out" / "report.html")
    text = " ".join(page.text.split())
    assert "480 of 480 samples kept, 4 joint readings in them missing." in text
    assert "240 of 240 samples kept (ankle missing in 4)" in text


def test_several_recordings_need_no_project(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    leg_file, out = tmp_path / LEG, tmp_path / "out"
    write_leg(bare(leg()), leg_file)
    time, measured = angles()
    head, names = "time [s],hip [deg],knee [deg],ankle [deg]\n", []
    for name, count in (("a", 300), ("b", 300), ("bad", 5)):
        rows = np.column_stack([time, measured + 0.01 * len(names)])[:count]
        (tmp_path / f"{name}.csv").write_text(head + "".join(",".join(f"{x:.5f}" for x in row) + "\n" for row in rows))
        names.append(str(tmp_path / f"{name}.csv"))
    words = ["--leg", str(leg_file), "--out", str(out)]
    for refused, told in (
        (names, "the other 2 recordings can be imported without those: do not name them"),
        ([names[0], names[0]], "is named twice"),
        ([str(tmp_path)], f"is a folder; name the files in it, such as {tmp_path}/*.csv"),
        ([names[0], str(tmp_path / "p.yaml")], "is a project, which is imported by itself"),
    ):
        assert main(["import", *refused, *words]) == 2
        assert told in capsys.readouterr().err
    (tmp_path / "p.yaml").write_text(f"kind: import\nleg: {LEG}\nfiles: ['*.csv']\n")
    assert main(["import", str(tmp_path / "p.yaml"), "--out", str(out)]) == 2
    assert "exclude: [bad.csv], or correct them" in capsys.readouterr().err
    assert not out.exists()
    assert main(["import", *names[:2], *words]) == 0
    assert sorted(path.name for path in (out / "trials").iterdir()) == ["a.csv", "b.csv"]
    account = json.loads((out / "import.json").read_text())
    assert [trial["source"] for trial in account["trials"]] == names[:2]
