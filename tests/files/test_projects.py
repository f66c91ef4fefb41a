"""Project files: every named file is read, every default reported, all mistakes reported together."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from synth.errors import UserError
from synth.files.gap_project import read_gap_project
from synth.files.hopper_recordings import read_plate_jumps, read_pull_ups
from synth.files.leg_file import PartResolver
from synth.files.projects import read_fit_project, read_leg_project

SHARED = Path(__file__).parents[3] / "shared"
ROWS = "".join(f"{i / 100},{90 + i},{150 - i}\n" for i in range(12))
CSV = "time [s],hip [deg],knee [deg]\n" + ROWS


def leg_text(length: str, extra: str = "") -> str:
    link = f"link: {{length: {length}, mass: 0.7 kg, com: 9 mm, inertia: 3e-3 kg*m^2}}"
    joint = f"zero: 90 deg\n    sign: +1\n    {link}\n{extra}"
    return f"kind: leg\nname: leg of {length}\njoints:\n  - name: hip\n    {joint}  - name: knee\n    {joint}"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("animal", "robot", "drops"):
        (tmp_path / name).mkdir()
    (tmp_path / "animal/a.leg.yaml").write_text(leg_text("50 mm"))
    (tmp_path / "robot/r.leg.yaml").write_text(leg_text("200 mm"))
    for name in ("animal/1.csv", "animal/2.csv", "drops/hip_1.csv"):
        (tmp_path / name).write_text(CSV)
    (tmp_path / "knee.csv").write_text("speed [rpm],torque [N*m]\n50,0.2\n")
    return tmp_path


def write(folder: Path, text: str) -> Path:
    path = folder / "project.yaml"
    path.write_text(text)
    return path


FIT = "kind: fit\nleg: animal/a.leg.yaml\ntrials: [animal/*.csv]\n"
DESIGN = """kind: leg-design
source: {leg: animal/a.leg.yaml, trials: [animal/*.csv]}
target: robot/r.leg.yaml
"""
SPRING = DESIGN + "select: {joints: {hip: {spring: "


def keys(error: UserError) -> list[str | None]:
    return [problem.key for problem in error.problems]


def test_fit_project_and_its_defaults(folder: Path) -> None:
    project = read_fit_project(write(folder, FIT))
    assert [trial.name for trial in project.trials] == ["animal/1.csv", "animal/2.csv"]
    assert project.leg.joint_names == ("hip", "knee")
    assert project.free_angle == "auto"
    assert (project.fit.method, project.fit.cost, project.fit.weight) == ("least_squares", "trajectory", "noise")
    assert project.prior is None
    assert [(d.key, d.value) for d in project.defaults] == [
        ("free_angle", "auto"),
        ("release", "free"),
        ("laws", "auto"),
        ("fit.method", "least_squares"),
        ("fit.cost", "trajectory"),
        ("fit.weight", "noise"),
        ("fit.intervals", "sensitivities"),
        ("tolerance.length", "0.5 %"),
        ("tolerance.mass", "1 %"),
        ("tolerance.com", "1 %"),
        ("tolerance.inertia", "2 %"),
    ]
    assert [file.name for file in project.inputs] == ["project.yaml", "animal/a.leg.yaml"]
    assert all(len(file.sha256) == 64 for file in project.inputs)


def test_fit_options_and_prior(folder: Path) -> None:
    spring = "    spring: {rate: 5 N*m/rad, free_angle: 90 deg}\n"
    (folder / "animal/a.leg.yaml").write_text(leg_text("50 mm", spring))
    text = FIT + "free_angle: per_trial\nfit: {method: swarm, seed: 3}\nprior: {spring: 20 %, free_angle: 5 deg}\n"
    project = read_fit_project(write(folder, text))
    assert (project.free_angle, project.fit.method, project.fit.seed) == ("per_trial", "swarm", 3)
    assert project.prior is not None
    assert project.prior.spring == pytest.approx(0.2)
    assert project.prior.free_angle == pytest.approx(math.radians(5))
    assert project.prior.damper is None
    listed = [d.key for d in project.defaults]
    assert listed[:5] == ["release", "laws", "fit.cost", "fit.weight", "fit.intervals"]
    assert listed[5:] == ["tolerance.length", "tolerance.mass", "tolerance.com", "tolerance.inertia"]


@pytest.mark.parametrize(
    ("text", "found", "words"),
    [
        ("kind: fit\n", ["leg", None], '"leg" is missing'),
        (FIT.replace("[animal/*.csv]", "[]"), ["trials"], "at least 1"),
        (FIT.replace("[animal/*.csv]", "animal/*.csv"), ["trials"], "a list"),
        (FIT.replace("a.leg", "b.leg"), ["leg"], "did you mean a.leg.yaml"),
        (FIT + "free_angle: automatic\n", ["free_angle"], "did you mean auto?"),
        (FIT + "fit: {method: least_square}\n", ["fit.method"], "did you mean least_squares"),
        (FIT + "fit: {seed: -1}\n", ["fit.seed"], "greater"),
        (FIT + "fit: 5\n", ["fit"], "mapping"),
        (FIT + "prior: {spring: 20 %}\n", ["prior.spring"], "has a spring in its file"),
        (FIT + "prior: {spring: 5 deg}\n", ["prior.spring"], "a ratio"),
        (FIT + "prior: {spring: 5}\n", ["prior.spring"], "5 is not allowed without a unit: write 5 %, or 500 % if"),
        (FIT + "trails: []\n", ["trails"], "did you mean trials"),
        (FIT.replace("[animal/*.csv]", "[{file: animal/1.csv, held_out: true}]"), ["trials"], "none remains to fit"),
        (FIT.replace("[animal/*.csv]", "[animal/1.csv, drop/*.csv]"), ["trials[2]"], "matches no file"),
        (FIT.replace("animal/a.leg.yaml", "../a.leg.yaml"), ["leg"], "leads out"),
        (FIT.replace("animal/a.leg.yaml", "animal/1.csv"), [None], "key: value"),
    ],
)
def test_bad_fit_projects(folder: Path, text: str, found: list[str | None], words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_fit_project(write(folder, text))
    assert keys(caught.value) == found
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("leg-design", 'read by "synth leg"'), ("gap", 'read by "synth gap"'), ("leg", "named by a project"),
     ("fitt", "did you mean fit?"), ("7", "is no kind")],
)  # fmt: skip
def test_wrong_kind_names_the_right_command(folder: Path, kind: str, words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_fit_project(write(folder, FIT.replace("kind: fit", f"kind: {kind}")))
    assert words in str(caught.value)
    assert caught.value.problems[0].line == 1


def test_mistakes_of_leg_and_project_together(folder: Path) -> None:
    (folder / "animal/a.leg.yaml").write_text(leg_text("-50 mm"))
    with pytest.raises(UserError) as caught:
        read_fit_project(write(folder, FIT + "free_angle: x\n"))
    assert [(Path(p.file or "").name, p.line) for p in caught.value.problems] == [
        ("project.yaml", 4),
        ("a.leg.yaml", 7),
        ("a.leg.yaml", 11),
    ]


def test_leg_project(folder: Path) -> None:
    text = (
        DESIGN
        + """name: big
scale: {time: froude}
select:
  joints:
    hip: {spring: {make: true}, damper: {direction: both, travel: 180 deg}}
    knee: {spring: {rate_tolerance: 5 %, included_angle: 120 deg, max_outer_diameter: 1.25 in}}
dampers:
  hip: {part: D1, leg: robot/r.leg.yaml, trials: [drops/*.csv], locked: [knee]}
  knee: {curve: knee.csv}
cad: {bed: [320 mm, 20 cm, 15 cm]}
"""
    )
    project = read_leg_project(write(folder, text))
    assert project.name == "big"
    assert project.time_scale == pytest.approx(2.0)  # sqrt(200 mm / 50 mm)
    assert project.dynamic_similarity
    hip, knee = project.joints["hip"], project.joints["knee"]
    assert (hip.spring.make, hip.spring.wire, hip.damper.direction) == (True, "music", "both")
    assert hip.damper.travel == pytest.approx(math.pi)
    assert knee.spring.rate_tolerance == pytest.approx(0.05)
    assert knee.spring.max_outer_diameter == pytest.approx(0.03175)
    assert project.dampers["hip"].part == "D1"
    assert project.dampers["hip"].trials[0].locked == ("knee",)
    assert project.dampers["knee"].curve is not None
    assert project.dampers["knee"].curve.torque == (0.2,)
    assert project.cad.bed == pytest.approx((0.32, 0.2, 0.15))
    assert project.cad.shaft_diameter == pytest.approx(0.008)
    defaults = {d.key: d.value for d in project.defaults}
    assert defaults["cad.shaft_diameter"] == "8 mm"
    assert defaults["cad.clearance"] == "0.4 mm"
    assert defaults["select.joints.hip.spring.wire"] == "music"
    assert defaults["select.joints.hip.spring.rate_tolerance"] == "10 %"
    assert defaults["select.joints.knee.damper.direction"] == "both"
    assert "cad.bed" not in defaults
    assert "select.joints.knee.spring.rate_tolerance" not in defaults
    assert [file.name for file in project.inputs] == [
        "project.yaml", "animal/a.leg.yaml", "robot/r.leg.yaml", "knee.csv"
    ]  # fmt: skip


@pytest.mark.parametrize(("gravity", "factor"), [("9.81 m/s^2", 2.0), ("1.62 m/s^2", 2.0 * math.sqrt(9.81 / 1.62))])
def test_equal_froude_numbers_hold_between_gravities(folder: Path, gravity: str, factor: float) -> None:
    """Times go as sqrt(length / gravity): a leg with its weight relieved, or on the Moon, moves slower."""
    robot = folder / "robot/r.leg.yaml"
    robot.write_text(f"{robot.read_text()}gravity: {gravity}\n")
    project = read_leg_project(write(folder, DESIGN + "scale: {time: froude}\n"))
    assert project.time_scale == pytest.approx(factor)


def test_without_gravity_there_is_no_froude_number(folder: Path) -> None:
    robot = folder / "robot/r.leg.yaml"
    robot.write_text(f"{robot.read_text()}gravity: 0 m/s^2\n")
    with pytest.raises(UserError, match="has gravity 0; write a factor") as caught:
        read_leg_project(write(folder, DESIGN + "scale: {time: froude}\n"))
    assert caught.value.problems[0].key == "scale.time"


@pytest.mark.parametrize(("written", "share"), [("5 %", 0.05), ("0.05", 0.05), ("1", 1.0), ("250 %", 2.5)])
def test_a_share_with_and_without_per_cent(folder: Path, written: str, share: float) -> None:
    text = DESIGN + f"select: {{joints: {{hip: {{spring: {{rate_tolerance: {written}}}}}}}}}\n"
    assert read_leg_project(write(folder, text)).joints["hip"].spring.rate_tolerance == pytest.approx(share)


def test_leg_project_defaults(folder: Path) -> None:
    project = read_leg_project(write(folder, DESIGN))
    assert (project.time_scale, project.dynamic_similarity) == (1.0, False)
    assert set(project.joints) == {"hip", "knee"}
    assert project.dampers == {}
    assert ("scale.time", "1.0") in [(d.key, d.value) for d in project.defaults]
    assert all(d.reason for d in project.defaults)


def test_catalogue_opens_with_the_users_files(folder: Path) -> None:
    (folder / "parts").mkdir()
    (folder / "parts/mine.csv").write_text("part\n")
    (folder / "robot/r.leg.yaml").write_text(leg_text("200 mm", "    spring: {part: S9, free_angle: 10 deg}\n"))
    seen: list[Path] = []

    def open_catalogue(paths: object) -> PartResolver:
        seen.extend(paths)  # type: ignore[call-overload]
        return lambda kind, part: 7.5

    text = DESIGN + "select: {catalogs: [parts/*.csv]}\n"
    project = read_leg_project(write(folder, text), open_catalogue=open_catalogue)
    assert [path.name for path in seen] == ["mine.csv"]
    assert project.target.joints[0].spring is not None
    assert project.target.joints[0].spring.rate == pytest.approx(7.5)
    assert "parts/mine.csv" in [file.name for file in project.inputs]


@pytest.mark.parametrize(
    ("text", "found", "words"),
    [
        ("kind: leg-design\n", ["source", "target"], '"source" is missing'),
        (DESIGN + "scale: {time: frode}\n", ["scale.time"], "froude"),
        (DESIGN + "scale: {time: 2 s}\n", ["scale.time"], "a ratio"),
        (DESIGN + "select: {joints: {hip: {spring: {rate_tolerance: 5}}}}\n",
         ["select.joints.hip.spring.rate_tolerance"], "5 is not allowed without a unit: write 5 %, or 500 %"),
        (DESIGN + "scale: {time: -2}\n", ["scale.time"], "between"),
        (DESIGN + "cad: {bed: [320, 132 mm, 154 mm]}\n", ["cad.bed[1]"], "320 has no unit"),
        (DESIGN + "cad: {bed: [320 mm, 132]}\n", ["cad.bed[2]", "cad.bed"], "has 2 items; at least 3 are needed"),
        (DESIGN + "scale: {tme: 2}\n", ["scale.tme"], "did you mean time"),
        (DESIGN + "select: {catalogs: [my/*.csv]}\n", ["select.catalogs[1]"], "matches no file"),
        (DESIGN + "select: {joints: {hipp: {}}}\n", ["select.joints.hipp"], "did you mean hip"),
        (DESIGN + "select: {joints: {hip: {sprung: {}}}}\n", ["select.joints.hip.sprung"], "did you mean spring"),
        (SPRING + "{make: false, wire: music}}}}\n", ["select.joints.hip.spring.wire"], "make is false"),
        (SPRING + "{make: true, part: X}}}}\n", ["select.joints.hip.spring"], "keep one"),
        (SPRING + "{included_angle: 3600 deg}}}}\n", ["select.joints.hip.spring.included_angle"], "at most 360 deg"),
        (SPRING + "{travel: 3600 deg}}}}\n", ["select.joints.hip.spring.travel"], "at most 720 deg"),
        (DESIGN + "select: {within: 3600 deg}\n", ["select.within"], "at most 180 deg"),
        (DESIGN + "select: {tolerance: {free_angle: 500 deg}}\n", ["select.tolerance.free_angle"], "at most 180 deg"),
        (DESIGN + "select: {joints: {hip: {damper: {direction: bth}}}}\n", ["select.joints.hip.damper.direction"],
         "did you mean both"),
        (DESIGN + "select: {joints: {hip: {damper: {direction: one}}}}\n", ["select.joints.hip.damper.direction"],
         "parallel: 2 allows two one-way dampers as a pair"),
        (DESIGN + "select: {joints: {hip: {spring: {min_body_length: 2 in, max_body_length: 1 in}}}}\n",
         ["select.joints.hip.spring.min_body_length"], "no spring fits"),
        (DESIGN + "dampers: {ankle: {curve: knee.csv}}\n", ["dampers.ankle"], "is no joint"),
        (DESIGN + "dampers: {hip: {part: D1}}\n", ["dampers.hip"], "curve"),
        (DESIGN + "dampers: {hip: {leg: robot/r.leg.yaml}}\n", ["dampers.hip"], "trials"),
        (DESIGN + "dampers: {hip: {curve: knee.csv, leg: robot/r.leg.yaml}}\n", ["dampers.hip"], "both given"),
        (DESIGN + "dampers: {hip: {leg: robot/r.leg.yaml, trials: [drops/*.csv], locked: [hip]}}\n",
         ["dampers.hip.locked"], "locked in its own drops"),
        (DESIGN + "dampers: {hip: {leg: robot/r.leg.yaml, trials: [drops/*.csv], locked: [kne]}}\n",
         ["dampers.hip.locked.kne"], "did you mean knee"),
        (DESIGN + "cad: {shaft_diameter: 0.25 in, wall: 0.5 in}\n", ["cad.shaft_diameter", "cad.wall"],
         "0.25 in is not allowed: it must be one of 3, 4, 5, 6, 8, 10, 12, 15 and 20 mm"),
        (DESIGN + "cad: {clearance: 0.05 mm, safety: 0.9, between_layers: 2 %}\n",
         ["cad.clearance", "cad.between_layers", "cad.safety"], "at least 0.1 mm"),
        (DESIGN + "cad: {wall: 3, bed: [100 mm, 200 mm]}\n", ["cad.wall", "cad.bed"], "at least 3"),
    ],
)  # fmt: skip
def test_bad_leg_projects(folder: Path, text: str, found: list[str], words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_leg_project(write(folder, text))
    assert keys(caught.value) == found
    assert words in str(caught.value)


def test_other_joints_in_source_and_target(folder: Path) -> None:
    (folder / "robot/r.leg.yaml").write_text(leg_text("200 mm").replace("knee", "ankle"))
    with pytest.raises(UserError, match="the target's joints are hip, ankle, the source's hip, knee"):
        read_leg_project(write(folder, DESIGN))


@pytest.mark.skipif(not SHARED.is_dir(), reason="the lab's data lie outside the repository")
def test_real_fit_projects() -> None:
    for path in sorted((SHARED / "cases" / "fit").glob("*/fit.yaml")):
        assert len(read_fit_project(path).trials) == 6


@pytest.mark.skipif(not SHARED.is_dir(), reason="the lab's data lie outside the repository")
def test_real_leg_project(tmp_path: Path) -> None:
    import shutil

    shutil.copytree(SHARED / "aarl", tmp_path / "aarl", copy_function=shutil.copy)
    path = tmp_path / "leg.yaml"
    path.write_text(
        """kind: leg-design
name: rat dynamics in a dog-sized leg
source: {leg: aarl/rat/rat.leg.yaml, trials: [aarl/rat/releases/*.csv]}
scale: {time: 2}
target: aarl/dog/dog.leg.yaml
fit: {method: least_squares, cost: trajectory, weight: amplitude}
select:
  joints:
    hip:   {spring: {make: true, wire: music}, damper: {direction: both, travel: 360 deg}}
    ankle: {}
dampers:
  hip:
    {part: D21, leg: aarl/dog/dog_dampers.leg.yaml, trials: [aarl/dog/damper_drops/hip_?.csv], locked: [knee, ankle]}
cad: {shaft_diameter: 8 mm, clearance: 0.4 mm, wall: 3 mm, bed: [320 mm, 132 mm, 154 mm]}
"""
    )
    project = read_leg_project(path)
    assert (len(project.trials), project.time_scale, len(project.dampers["hip"].trials)) == (30, 2.0, 8)


@pytest.mark.parametrize("kind", ["hopper-jumps", "hopper-pull-ups", "gap"])
def test_a_pipe_in_place_of_a_design_is_refused_and_not_waited_for(folder: Path, kind: str) -> None:
    os.mkfifo(folder / "hopper.yaml")
    texts = {
        "hopper-jumps": "design: hopper.yaml\nmotor: m\nlength: 120 mm\njumps: [knee.csv]\n",
        "hopper-pull-ups": "design: hopper.yaml\nbody_mass: 30 g\ntrials: [{file: knee.csv, length: 120 mm}]\n",
        "gap": "leg: hopper.yaml\ntrials: [knee.csv]\n",
    }
    read = {"hopper-jumps": read_plate_jumps, "hopper-pull-ups": read_pull_ups, "gap": read_gap_project}[kind]
    with pytest.raises(UserError, match="is not a regular file"):
        read(write(folder, f"kind: {kind}\n{texts[kind]}"))


def test_a_pipe_among_catalogues_is_refused_and_not_waited_for(folder: Path) -> None:
    os.mkfifo(folder / "parts.csv")
    with pytest.raises(UserError, match="is not a regular file"):
        read_leg_project(write(folder, DESIGN + "select: {catalogs: [parts.csv]}\n"))


def test_measured_dampers_are_read_joint_by_joint(folder: Path) -> None:
    shape = "{bolt_circle: 52 mm, bolts: 3, shaft_side: bore, shaft_form: square, shaft_size: 6 mm}"
    project = read_leg_project(write(folder, DESIGN + f"cad: {{dampers: {{hip: {shape}}}}}\n"))
    found = project.cad.dampers["hip"]
    assert (found.bolts, found.shaft_side, found.shaft_form) == (3, "bore", "square")
    assert (found.bolt_circle, found.shaft_size) == pytest.approx((0.052, 0.006))
    assert found.outer_diameter is None


@pytest.mark.parametrize(
    ("cad", "words"),
    [
        ("{dampers: {hipp: {bolts: 3}}}", "hipp"),
        ("{dampers: {hip: {shaft_form: star}}}", "star"),
        ("{dampers: {hip: {bolt_circle: 52}}}", "52"),
        ("{damper_shafts: {hip: 6 mm}, dampers: {hip: {shaft_size: 6 mm}}}", "given twice"),
    ],
)
def test_mistakes_in_measured_dampers_are_reported(folder: Path, cad: str, words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_leg_project(write(folder, DESIGN + f"cad: {cad}\n"))
    assert words in str(caught.value)
    assert all((problem.key or "").startswith("cad.dampers") for problem in caught.value.problems)


@pytest.mark.parametrize(
    ("spring", "words"),
    [
        ("{rate: 3 N*m/rad, rate_held: joint, rate_distance: 20 mm}", "belongs to a loose spring"),
        ("{rate: 3 N*m/rad, free_angle_by: torque}", 'says how "free_angle" was found, which is not given'),
        ("{free_angle: 98 deg, rate_held: joint}", 'how "rate" was measured'),
        ("{rate: 3 N*m/rad, rate_held: vice}", "vice"),
        ("{rate_held: joint}", 'needs "free_angle", "rate" or both'),
    ],
)
def test_mistakes_in_measured_springs_are_reported(folder: Path, spring: str, words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_leg_project(write(folder, DESIGN + f"measured: {{spring: {{hip: {spring}}}}}\n"))
    assert words in str(caught.value)
    assert all((problem.key or "").startswith("measured.spring.hip") for problem in caught.value.problems)
