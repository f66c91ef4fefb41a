"""The gap's project file: tolerances with their defaults, the nominal leg's missing parts, every mistake reported."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from synth.errors import UserError
from synth.files.gap_project import Tolerance, read_gap_project

ROWS = "".join(f"{i / 100},{90 + i},{150 - i}\n" for i in range(12))
SPRING = "    spring: {rate: 5 N*m/rad, free_angle: 100 deg}\n"
DAMPER = "    damper: {rate: 0.1 N*m*s/rad}\n"
GAP = "kind: gap\nleg: nominal.leg.yaml\ntrials: [trials/*.csv]\n"


def leg_text(hip: str = SPRING + DAMPER, knee: str = SPRING + DAMPER) -> str:
    link = "link: {length: 200 mm, mass: 0.7 kg, com: 90 mm, inertia: 3e-3 kg*m^2}"
    head = "kind: leg\nname: built leg\njoints:\n"
    return head + "".join(
        f"  - name: {name}\n    zero: 90 deg\n    sign: +1\n    {link}\n{parts}"
        for name, parts in (("hip", hip), ("knee", knee))
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "trials").mkdir()
    (tmp_path / "nominal.leg.yaml").write_text(leg_text())
    for name in ("a", "b"):
        (tmp_path / "trials" / f"{name}.csv").write_text("time [s],hip [deg],knee [deg]\n" + ROWS)
    return tmp_path


def write(folder: Path, text: str) -> Path:
    path = folder / "gap.yaml"
    path.write_text(text)
    return path


def test_omitted_keys_have_the_format_s_defaults_and_are_reported(folder: Path) -> None:
    project = read_gap_project(write(folder, GAP))
    assert project.name == "built leg"
    assert [trial.name for trial in project.trials] == ["trials/a.csv", "trials/b.csv"]
    assert project.tolerance == Tolerance(0.005, 0.01, 0.01, 0.02, 0.03, 0.05, math.radians(0.5))
    assert [(d.key, d.value) for d in project.defaults] == [
        ("tolerance.length", "0.5 %"),
        ("tolerance.mass", "1 %"),
        ("tolerance.com", "1 %"),
        ("tolerance.inertia", "2 %"),
        ("tolerance.spring", "3 %"),
        ("tolerance.damper", "5 %"),
        ("tolerance.free_angle", "0.5 deg"),
    ]
    assert [file.name for file in project.inputs] == ["gap.yaml", "nominal.leg.yaml"]


def test_tolerances_in_any_unit_and_only_the_missing_ones_are_defaults(folder: Path) -> None:
    text = GAP + "name: mine\nseed: 7\ntolerance: {mass: 0.02, spring: 10 percent, free_angle: 0.01 rad, length: 0 %}\n"
    project = read_gap_project(write(folder, text))
    assert (project.name, project.seed) == ("mine", 7)
    assert project.tolerance.mass == 0.02
    assert project.tolerance.spring == pytest.approx(0.1)
    assert project.tolerance.free_angle == 0.01
    assert project.tolerance.length == 0.0
    assert [d.key for d in project.defaults] == ["tolerance.com", "tolerance.inertia", "tolerance.damper"]


@pytest.mark.parametrize(
    ("written", "key", "said"),
    [
        ("spring: 0.5", "spring", "0.5 is not allowed without a unit: write 0.5 %, or 50 % if that is meant"),
        ("mass: 1", "mass", "1 is not allowed without a unit: write 1 %"),
        ("knee: {mass: 0.2}", "knee.mass", "0.2 is not allowed without a unit: write 0.2 %, or 20 % if that is meant"),
        ("mass: 60 %", "mass", "60 % is not allowed: it can be at most 50 %"),
    ],
)
def test_a_tolerance_that_lacks_its_percent_sign_is_refused(folder: Path, written: str, key: str, said: str) -> None:
    """Read as 50 %, a spring a third too stiff was within its tolerance, and nothing was missing."""
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, GAP + f"tolerance: {{{written}}}\n"))
    assert [(problem.key, problem.text) for problem in caught.value.problems] == [(f"tolerance.{key}", said)]


def test_a_tolerance_of_zero_for_everything_is_a_leg_known_exactly(folder: Path) -> None:
    keys = ("length", "mass", "com", "inertia", "spring", "damper")
    text = ", ".join([*(f"{key}: 0 %" for key in keys), "free_angle: 0 deg"])
    project = read_gap_project(write(folder, GAP + f"tolerance: {{{text}}}\n"))
    assert project.tolerance == Tolerance(0, 0, 0, 0, 0, 0, 0)
    assert project.defaults == ()


def test_noise_of_a_joint_and_the_required_accuracy_are_read(folder: Path) -> None:
    project = read_gap_project(write(folder, GAP + "noise: {knee: 0.02 deg}\naccuracy: 0.3 deg\n"))
    assert project.noise == {"knee": pytest.approx(math.radians(0.02))}
    assert project.accuracy == pytest.approx(math.radians(0.3))


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ("tolerance: {mass: -1 %}\n", "tolerance.mass", "at least 0 %"),
        ("tolerance: {mass: 51 %}\n", "tolerance.mass", "at most 50 %"),
        ("tolerance: {free_angle: 0.5 %}\n", "tolerance.free_angle", "angle"),
        ("tolerance: {free_angle: -1 deg}\n", "tolerance.free_angle", "at least 0 deg"),
        ("tolerance: {spring: 0.1 N*m/rad}\n", "tolerance.spring", "ratio"),
        ("tolerance: {weight: 1 %}\n", "tolerance.weight", "is not a key"),
        ("tolerance: 5 %\n", "tolerance", "mapping"),
        ("seed: -1\n", "seed", "greater"),
        ("noise: 0.1 deg\n", "noise", "no mapping of joints: write noise: {knee: 0.02 deg}"),
        ("noise: {ankle: 0.1 deg}\n", "noise.ankle", "allowed here: hip, knee"),
        ("noise: {knee: 0.1 N}\n", "noise.knee", "where an angle is needed"),
        ("noise: {knee: 0 deg}\n", "noise.knee", "more than 0 deg"),
        ("accuracy: 0.3\n", "accuracy", "has no unit"),
        ("accuracy: 0.3 N*m\n", "accuracy", "where an angle is needed"),
        ("accuracy: -1 deg\n", "accuracy", "at least 0 deg"),
    ],
)
def test_bad_tolerances_and_keys(folder: Path, text: str, key: str, words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, GAP + text))
    (problem,) = caught.value.problems
    assert problem.key == key
    assert words in problem.text
    assert problem.line == 4


def test_a_project_without_leg_and_trials_reports_both(folder: Path) -> None:
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, "kind: gap\n"))
    assert [problem.key for problem in caught.value.problems] == ["leg", "trials"]


def test_all_trials_held_out_is_refused(folder: Path) -> None:
    text = GAP.replace("[trials/*.csv]", "[{file: trials/*.csv, held_out: true}]")
    with pytest.raises(UserError, match="every trial is held out"):
        read_gap_project(write(folder, text))


def test_a_missing_spring_or_damper_has_rate_zero_and_is_reported(folder: Path) -> None:
    (folder / "nominal.leg.yaml").write_text(leg_text(hip=DAMPER, knee=SPRING))
    project = read_gap_project(write(folder, GAP))
    hip, knee = project.leg.joints
    assert hip.spring is not None
    assert knee.damper is not None
    assert (hip.spring.rate, knee.damper.rate) == (0.0, 0.0)
    assert [(d.key, d.value) for d in project.defaults[-2:]] == [
        ("built leg: hip.spring", "0 N*m/rad"),
        ("built leg: knee.damper", "0 N*m*s/rad"),
    ]


def test_a_leg_with_no_spring_and_no_damper_at_all_is_one_for_a_fit(folder: Path) -> None:
    (folder / "nominal.leg.yaml").write_text(leg_text("", ""))
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, GAP))
    assert "(hip, knee) has a spring or a damper" in str(caught.value)
    assert "damper: {rate: 0 N*m*s/rad}" in str(caught.value)
    (folder / "nominal.leg.yaml").write_text(leg_text("    damper: {rate: 0 N*m*s/rad}\n", ""))
    assert read_gap_project(write(folder, GAP)).leg.joint_names == ("hip", "knee")


def test_columns_in_another_order_are_the_same_trial(folder: Path) -> None:
    usual = read_gap_project(write(folder, GAP)).trials[0]
    rows = [line.split(",") for line in ROWS.splitlines()]
    swapped = "knee [deg],time [s],hip [deg]\n" + "".join(f"{k},{t},{h}\n" for t, h, k in rows)
    (folder / "trials" / "a.csv").write_text(swapped)
    other = read_gap_project(write(folder, GAP)).trials[0]
    assert (other.angles == usual.angles).all()
    assert (other.time == usual.time).all()


def test_a_joint_may_have_tolerances_of_its_own(folder: Path) -> None:
    project = read_gap_project(write(folder, GAP + "tolerance: {mass: 2 %, knee: {mass: 5 %, free_angle: 3 deg}}\n"))
    widths = project.tolerance.widths(project.leg)
    np.testing.assert_allclose(widths[:, 0], [0.005, 0.02, 0.01, 0.02, 0.03, 0.05, math.radians(0.5), 0.0, 0.0])
    np.testing.assert_allclose(widths[:, 1], [0.005, 0.05, 0.01, 0.02, 0.03, 0.05, math.radians(3.0), 0.0, 0.0])
    assert "tolerance.mass" not in [d.key for d in project.defaults]


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ("{ankle: {mass: 5 %}}", "tolerance.ankle", '"ankle" is no joint of built leg'),
        ("{knee: {mass: 5 kg}}", "tolerance.knee.mass", "ratio"),
        ("{knee: {weight: 5 %}}", "tolerance.knee.weight", "is not a key"),
        ("{knee: 5 %}", "tolerance.knee", "is not a mapping of tolerances"),
    ],
)
def test_bad_tolerances_of_a_joint(folder: Path, text: str, key: str, words: str) -> None:
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, GAP + f"tolerance: {text}\n"))
    (problem,) = caught.value.problems
    assert problem.key == key
    assert words in problem.text
    assert problem.line == 4


def test_a_trial_may_have_a_leg_and_a_body_at_the_tip_of_its_own(folder: Path) -> None:
    (folder / "long.leg.yaml").write_text(leg_text().replace("200 mm", "300 mm"))
    items = "{file: trials/b.csv, leg: long.leg.yaml, tip_mass: {mass: 50 g, inertia: 2e-6 kg*m^2, at: 40 mm}}"
    text = f"kind: gap\nleg: nominal.leg.yaml\ntrials: [trials/a.csv, {items}]\n"
    first, second = read_gap_project(write(folder, text)).trials
    assert first.leg is None
    assert second.leg is not None
    assert second.leg.joints[0].link.length == pytest.approx(0.3)
    assert (second.tip_mass, second.tip_inertia, second.tip_at) == pytest.approx((0.05, 2e-6, 0.04))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("name: knee", "name: elbow"), "has other joints (hip, elbow)"),
        (("sign: +1", "sign: -1"), "zero or sign"),
    ],
)
def test_another_leg_needs_the_same_joints(folder: Path, change: tuple[str, str], words: str) -> None:
    (folder / "long.leg.yaml").write_text(leg_text().replace(*change))
    text = "kind: gap\nleg: nominal.leg.yaml\ntrials: [trials/a.csv, {file: trials/b.csv, leg: long.leg.yaml}]\n"
    with pytest.raises(UserError) as caught:
        read_gap_project(write(folder, text))
    (problem,) = caught.value.problems
    assert words in problem.text
    assert problem.key == "trials[2].leg"


def test_a_suggested_command_has_stated_limits(folder: Path) -> None:
    stated = "next_command: {length: 2 s, limits: {knee: {lowest: -20 deg, speed: 90 deg/s, torque: 1.5 N*m}}}\n"
    found = read_gap_project(write(folder, GAP + stated)).next_command
    knee = found.limits["knee"]
    assert (found.length, knee.highest, knee.torque) == (2.0, None, 1.5)
    np.testing.assert_allclose([knee.lowest, knee.speed], np.radians([-20.0, 90.0]))
    assert read_gap_project(write(folder, GAP)).next_command.limits == {}


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ("{limits: {wrist: {speed: 90 deg/s}}}", "wrist"),
        ("{limits: {knee: {lowest: 20 deg, highest: 10 deg}}}", "not below"),
        ("{length: 0 s}", "length"),
        ("{limits: 3 N*m}", "no mapping of joints"),
    ],
)
def test_limits_that_cannot_be_kept_are_refused(folder: Path, stated: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        read_gap_project(write(folder, GAP + f"next_command: {stated}\n"))
