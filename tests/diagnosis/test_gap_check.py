"""The check of recordings: tampered ones are named, and separability agrees with closed forms."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import HANGING, NOISE, ONE, TIME, TWO, off, recorded, with_effects
from diagnosis.turning_pendulum import recorded as turned_over
from synth.cli import main
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.check import run
from synth.diagnosis.check.check_result import Check
from synth.diagnosis.check.clocks import clock_findings, describe_sampling
from synth.diagnosis.check.coverage import coverage_findings, describe_coverage
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.check.separability import VisibleCause
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.plants.swinging_chain.chain_menu import menu
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo, ServoSignals
from synth.files.gap_project import GapProject, Tolerance
from synth.files.recording import read_recording
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.reports.openings.check_opening import size_text
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, Leg, Spring

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "gap"
SHARED = Path(__file__).resolve().parents[3] / "shared" / "cases" / "gap"


def project(leg: Leg, trials: list[Trial]) -> GapProject:
    return GapProject(Path("gap.yaml"), leg.name, leg, tuple(trials), Tolerance(), 0, (), ())


def showing(found: Check, effect: str, joint: str) -> VisibleCause:
    return next(each for each in found.showings if each.key == (effect, joint))


def sine(found: Check, first: tuple[str, str], second: tuple[str, str]) -> float:
    keys = [each.key for each in found.showings]
    return float(found.sines[keys.index(first), keys.index(second)])


def faults(found: Check) -> list[Finding]:
    return [finding for finding in found.findings if finding.level == "fault"]


@pytest.fixture(scope="module")
def clean() -> Check:
    return run.check(project(TWO, recorded(off(TWO, 3), seed=1)))


def test_good_recordings_have_no_fault_and_correct_noise(clean: Check) -> None:
    assert clean.usable
    assert "can be used" in clean.sentence
    assert [channel.noise for channel in clean.channels] == pytest.approx([NOISE, NOISE], rel=0.1)
    assert all(channel.count == 0.0 for channel in clean.channels)
    assert all(lag.late.low is not None and lag.late.low < 0.0 < (lag.late.high or 0.0) for lag in clean.lags)


def test_stated_noise_is_used() -> None:
    quiet, loud = recorded(off(TWO, 3), seed=1), np.radians(0.5)
    found = run.check(replace(project(TWO, quiet), noise={"knee": loud}))
    assert found.channels[TWO.joint_names.index("knee")].noise == loud
    other = run.check(project(TWO, quiet))
    for told in (found, other):
        assert told.usable
    sizes = [showing(told, "coulomb_friction", "knee").visible_from for told in (found, other)]
    loudest, plain = (size["torque"].value if size else np.inf for size in sizes)
    assert loudest > 2.0 * plain


def test_an_accuracy_that_accepts_nearly_every_leg_is_doubted() -> None:
    """0.5 rad for 0.5 deg: every gap was within it, and the check said nothing."""
    given = project(TWO, recorded(off(TWO, 3), seed=1))
    for accuracy, told in ((0.5, ["doubt"]), (np.radians(0.5), [])):
        findings = run.check(replace(given, accuracy=accuracy)).findings
        assert [each.level for each in findings if "an accuracy of" in each.text] == told


HASHED = """
import sys
from dataclasses import replace
from pathlib import Path
from synth.files.output import write_json
sys.path.insert(0, sys.argv[1])
from diagnosis.simulated_releases import TWO, off, recorded
from diagnosis.test_gap_check import project
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.check import run
write_json(Path(sys.argv[2]), run.check(project(TWO, recorded(off(TWO, 3), seed=1))).as_json())
"""


@pytest.mark.slow  # like ``test_diagnosis``
def test_the_same_recordings_give_the_same_bytes(tmp_path: Path) -> None:
    """A set of names has another order under each seed of Python's hash."""
    written = []
    for seed in ("0", "1", "2"):
        tests = str(Path(__file__).resolve().parents[1])
        command = [sys.executable, "-c", HASHED, tests, str(tmp_path / f"{seed}.json")]
        subprocess.run(command, check=True, env={**os.environ, "PYTHONHASHSEED": seed})
        written.append((tmp_path / f"{seed}.json").read_bytes())
    assert len(set(written)) == 1


@pytest.mark.parametrize("slow", [True, False])
def test_a_servo_s_commands_are_no_free_motion(slow: bool) -> None:
    """Its leg moves as it is told: neither a clock in other units nor a recording that ends too early."""
    knee, hz = HANGING.joint_names[0], 0.02 if slow else 0.8
    leg = HANGING.with_joints(**{knee: {"drive": Servo(gain=6.0, damping_gain=0.15)}})
    time = np.arange(0.0, 0.95 / hz, 0.01 / hz)
    rest = leg.to_measured(leg.rest)
    angle = rest[0] + np.radians(30.0) * np.sin(2.0 * np.pi * hz * time)[:, None]
    signals = ServoSignals(time, angle, np.full((len(time), 1), 12.0), np.ones((len(time), 1)))
    made = recordings(leg, [Trial(name="a.csv", time=time, angles=angle, signals=signals)], ())
    assert all(recording.driven for recording in made)
    assert clock_findings(leg, made, [describe_sampling(leg, recording) for recording in made]) == []
    assert coverage_findings(leg, made, ()) == []
    free = [replace(recording, signals=None) for recording in made]
    assert bool(clock_findings(leg, free, [describe_sampling(leg, recording) for recording in free])) == slow
    assert len(coverage_findings(leg, free, ())) == 1


@pytest.mark.parametrize("own_leg", [False, True])
@pytest.mark.parametrize("at", [None, 0.02])
def test_the_bearing_carries_the_tip_where_it_is(at: float | None, own_leg: bool) -> None:
    """The force by second differences of the points of mass in the simulated swing; the tip was at the link's end."""
    leg = HANGING.with_joints(knee={"link": replace(HANGING.joints[0].link, mass=0.7)}) if own_leg else HANGING
    link, time = leg.joints[0].link, np.arange(1201) * 1e-3
    conditions = Conditions(tip_mass=0.4, tip_at=at)
    angle = simulate(leg, leg.rest + 1.2, [0.0], time, conditions)
    made = Trial("a.csv", time, leg.to_measured(angle), tip_mass=0.4, tip_at=at, leg=leg if own_leg else None)
    (one,) = describe_coverage(HANGING, recordings(HANGING, [made], ()))
    force = np.zeros((2, len(time) - 2))
    for mass, reach in ((link.mass, link.com), (0.4, link.length if at is None else at)):
        place = reach * np.stack([np.sin(angle[:, 0]), -np.cos(angle[:, 0])])
        force += mass * (np.diff(place, 2) / 1e-6 + np.array([[0.0], [leg.gravity]]))
    assert one.load == pytest.approx(np.percentile(np.hypot(*force), [5.0, 95.0]), rel=0.01)


def with_menu(trials: list[Trial], change: Callable[[AngleTrial], AngleTrial], kept: list[Any]) -> Check:
    """The check with changed trials on its menu, which are ``kept``."""

    def changed(leg: Leg, bench: Workbench, given: Sequence[AngleTrial]) -> list[MenuItem[AngleTrial]]:
        kept.extend(replace(item, trial=change(item.trial)) for item in menu(leg, bench, given))
        return kept

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "menu", changed)
        return run.check(project(TWO, trials))


def test_a_trial_that_tells_nothing_separates_nothing() -> None:
    """Readings a million times as noisy. Nine of fourteen pairs counted as better told apart by such a trial."""
    found = with_menu(recorded(off(TWO, 3), seed=1), lambda t: replace(t, relative=np.full(t.measured.shape, 1e6)), [])
    assert len(found.clusters) >= 4
    assert [(one.remedy, one.with_trial) for one in found.clusters] == [("", one.sine) for one in found.clusters]


def test_a_named_trial_separates_as_much_once_it_is_recorded() -> None:
    """A mass at the tip, which tells dry from load-dependent friction; a larger release was named for it.

    Of two late channels a locked one seemed to tell which it is, from a sine of 0.010 to 0.14: the prior of the
    imagined trial's initial rate was that of a leg at rest, and a late channel alone is another initial rate.
    """
    trials, items = recorded(off(TWO, 3), seed=1), list[Any]()
    clusters = with_menu(trials, lambda t: t, items).clusters
    (late,) = [one for one in clusters if one.keys[0][0] == "latency"]
    (rubs,) = [one for one in clusters if ("load_friction", "hip") in one.keys]
    assert "locked" not in late.remedy
    assert rubs.remedy == "a mass of 175 g at the tip"
    state = next(item.trial.measured[0] for item in items if item.what == rubs.remedy)
    angle = TWO.to_measured(simulate(TWO, state, [0.0, 0.0], TIME, Conditions(tip_mass=0.175)))
    angle += NOISE * np.random.default_rng(7).standard_normal(angle.shape)
    found = run.check(project(TWO, [*trials, Trial("extra.csv", TIME, angle, tip_mass=0.175)]))
    now = min(sine(found, *rubs.keys), sine(found, *rubs.keys[::-1]))
    assert now == pytest.approx(rubs.with_trial, rel=0.2)


def test_base_tilt_and_encoder_offset_are_inseparable_without_a_spring() -> None:
    """Closed form: gravity alone knows where down is, so to turn both base and reading changes nothing."""
    bare = HANGING.with_joints(knee={"spring": Spring(0.0, 1.8), "damper": Damper(0.004)})
    swings = [replace(trial) for trial in recorded(bare, np.array([[0.5], [-0.4], [0.7]]) - 0.0, held_out=0)]
    found = run.check(project(bare, swings))
    assert sine(found, ("base_tilt", "base"), ("encoder_offset", "knee")) < 0.03
    assert sine(found, ("base_tilt", "base"), ("coulomb_friction", "knee")) > 0.5
    cluster = next(each for each in found.clusters if ("base_tilt", "base") in each.keys)
    assert ("encoder_offset", "knee") in cluster.keys


def test_mass_and_inertia_are_inseparable_without_gravity() -> None:
    """Closed form: the equation has the inertia about the joint alone, to which mass, com and rotor all add."""
    weightless = replace(ONE, gravity=0.0)
    found = run.check(project(weightless, recorded(weightless, np.array([[0.5], [-0.4], [0.7]]), held_out=0)))
    assert sine(found, ("link_mass", "knee"), ("armature", "knee")) < 0.05
    assert sine(found, ("armature", "knee"), ("link_inertia", "knee")) < 0.05


def test_an_effect_at_the_visible_size_leaves_three_deviations() -> None:
    """The claim itself: friction of the size that is said to show, in recordings without noise, then fitted away."""
    from synth.diagnosis.angle_search import as_designed, fit_nominal
    from synth.diagnosis.check.cause_responses import VISIBLE_SIGNAL
    from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of

    away = np.array([[0.5], [-0.4], [0.7]])
    noisy = recorded(ONE, away, held_out=0)
    found = run.check(project(ONE, noisy))
    shown = showing(found, "coulomb_friction", "knee").visible_from
    assert shown is not None
    rubbing = with_effects(ONE, {"knee": {"coulomb_friction": {"torque": shown["torque"].value}}})
    still = recorded(rubbing, away, noise=0.0, held_out=0)
    scene, _ = scene_of(ONE, noisy, Tolerance(), 0)
    noise = scene.bench.noise
    quiet, _ = scene_of(ONE, still, Tolerance(), 0)
    sized = np.hypot(noise, run.UNEXPLAINED_SHARE * np.array([channel.motion for channel in found.channels]))
    bench = replace(quiet.bench, noise=sized)
    fitted = fit_nominal(bench, as_designed(bench))
    left = sum(float(r @ r) for r in fitted.residuals) + float(fitted.unknowns @ fitted.unknowns)
    assert np.sqrt(left) == pytest.approx(VISIBLE_SIGNAL, rel=0.25)


def test_a_heavier_link_is_no_smaller_than_its_spring_and_damper_let_it_be() -> None:
    """Mass and inertia larger by a share move as spring and damper smaller by it, of which the tolerances take most.

    With these the signal of a share is at most its deviations of the two, so three deviations are a lower limit.
    """
    found = run.check(project(ONE, recorded(ONE, np.array([[0.6], [-0.5], [0.3]]), seed=2, held_out=0)))
    told, tolerance = showing(found, "link_mass", "knee").visible_from, Tolerance()
    assert told is not None
    share = float(np.log1p(told["share"].value))
    assert np.hypot(share / tolerance.spring, share / tolerance.damper) > 2.9


def test_a_damper_that_thins_shows_from_a_few_per_cent_and_is_told_apart_from_more() -> None:
    """Its usual loss, the prior's centre, is half: sizes counted from there said that less than 50 % does not show."""
    found = run.check(project(ONE, recorded(ONE, np.array([[0.5], [-0.4], [0.7]]), held_out=0)))
    thinning = showing(found, "shear_thinning_damping", "knee")
    assert thinning.visible_from is not None
    assert 0.005 < thinning.visible_from["loss"].value < 0.1
    for rival in thinning.rivals:
        if rival.parts_from is not None:
            assert rival.parts_from["loss"].value > thinning.visible_from["loss"].value


def test_a_stop_is_stated_by_its_place(clean: Check) -> None:
    """Its stiffness said nothing: 124 307 N m/rad of the gap example's hip."""
    angles = np.concatenate([trial.angles for trial in recorded(off(TWO, 3), seed=1)])
    for j, joint in enumerate(TWO.joint_names):
        stop = showing(clean, "joint_stop", joint)
        assert stop.visible_from is not None
        assert set(stop.visible_from) == {"upper", "lower"}
        lower, upper = (stop.visible_from[end].as_json() for end in ("lower", "upper"))
        assert {lower["unit"], upper["unit"]} == {"deg"}
        low, high = np.degrees([angles[:, j].min(), angles[:, j].max()])
        assert low < lower["value"] < 0.5 * (low + high) < upper["value"] < high
        assert all(rival.parts_from == {} for rival in stop.rivals)
        shown = size_text(stop.as_json()["visible_from"])
        assert re.fullmatch(r"an end above at [\d.]+°, an end below at [\d.]+°", shown)


def test_halving_the_remainder_halves_the_visible_size(monkeypatch: pytest.MonkeyPatch) -> None:
    trials = recorded(ONE, np.array([[0.5], [-0.4], [0.7]]), noise=1e-6, held_out=0)
    whole = run.check(project(ONE, trials))
    monkeypatch.setattr(run, "UNEXPLAINED_SHARE", 0.5 * run.UNEXPLAINED_SHARE)
    half = run.check(project(ONE, trials))
    for effect, name in (("coulomb_friction", "torque"), ("backlash", "gap")):
        first, second = (showing(found, effect, "knee").visible_from for found in (whole, half))
        assert first is not None
        assert second is not None
        assert second[name].value == pytest.approx(0.5 * first[name].value, rel=0.25)


def test_a_frozen_reading_is_stated_as_the_file_has_it() -> None:
    """It was the joint's rotation: without the zero, and of the other sign where the joint's is -1 (the knee's)."""
    trials = recorded(off(TWO, 3), seed=1)
    damaged = [trials[0], _frozen(trials[1]), _held(trials[2])]
    knee, hip = (fault.text for fault in sorted(faults(run.check(project(TWO, damaged))), key=lambda f: f.recording))
    assert knee.startswith(f"its reading stays at {np.degrees(damaged[1].angles[10, 1]):.3g} deg from ")
    assert hip.startswith(f"reads {np.degrees(damaged[2].angles[0, 0]):.3g} deg from ")


def _frozen(trial: Trial) -> Trial:
    angles = trial.angles.copy()
    angles[10:30, 1] = angles[10, 1]
    return replace(trial, angles=angles)


def _held(trial: Trial) -> Trial:
    angles = trial.angles.copy()
    angles[:, 0] = angles[0, 0]
    return replace(trial, angles=angles)


def _holes(trial: Trial) -> Trial:
    kept = np.r_[0:40, 70:201]
    return replace(trial, time=trial.time[kept], angles=trial.angles[kept])


@pytest.mark.parametrize(
    ("tamper", "level", "words", "joint"),
    [
        (_frozen, "fault", "frozen there", "knee"),
        (_held, "fault", "frozen, or the joint was held", "hip"),
        (_holes, "doubt", "1 gap in its samples", ""),
    ],
)
def test_a_damaged_recording_is_named(tamper: Callable[[Trial], Trial], level: str, words: str, joint: str) -> None:
    trials = recorded(off(TWO, 3), seed=1)
    trials[1] = tamper(trials[1])
    found = run.check(project(TWO, trials))
    (finding,) = [each for each in found.findings if words in each.text]
    assert (finding.level, finding.recording, finding.joint) == (level, trials[1].name, joint)
    assert finding.remedy


def test_exchanged_columns_are_detected() -> None:
    trials = [replace(t, angles=t.angles[:, ::-1]) for t in recorded(off(TWO, 3), seed=1)]
    found = run.check(project(TWO, trials))
    assert "the columns of hip and knee look exchanged" in faults(found)[0].text


def test_an_inverted_joint_is_detected() -> None:
    trials = recorded(off(TWO, 3), seed=1)
    turned = [replace(t, angles=np.column_stack([t.angles[:, 0], 2.0 * TWO.zero[1] - t.angles[:, 1]])) for t in trials]
    found = run.check(project(TWO, turned))
    assert "knee looks inverted" in faults(found)[0].text


@pytest.mark.parametrize(("factor", "words"), [(np.radians(1.0), "radians labelled deg"), (np.degrees(1.0), "degrees")])
def test_angles_in_the_other_unit_are_detected(factor: float, words: str) -> None:
    trials = [replace(t, angles=t.angles * [1.0, factor]) for t in recorded(off(TWO, 3), seed=1)]
    (fault,) = faults(run.check(project(TWO, trials)))
    assert f"the angles of knee look like {words}" in fault.text
    assert f"knee [{'rad' if factor < 1.0 else 'deg'}]" in fault.remedy


def test_another_leg_is_no_other_unit() -> None:
    """Divided by 57 its motion is near a leg at rest, which is at 0 deg as the encoder has it; that is no fit."""
    spring = TWO.joints[1].spring
    assert spring is not None
    near_zero = TWO.with_joints(knee={"spring": replace(spring, free_angle=0.0), "zero": 0.2})
    other = near_zero.with_joints(knee={"spring": replace(spring, rate=0.3, free_angle=0.0)})
    assert faults(run.check(project(near_zero, recorded(other, seed=1)))) == []


@pytest.mark.parametrize(
    ("written", "scale", "words", "remedy"),
    [
        ("ms", 1e-3, "seconds labelled ms", "time [s]"),
        ("s", 1e3, "milliseconds labelled s", "time [ms]"),
        ("us", 1e-3, "milliseconds labelled us", "time [ms]"),
        ("s", 1e-3, "1 000 times too small", "multiply them by 1 000"),
        ("", 1e-3, "1 000 times too small", "multiply them by 1 000"),
        ("s", 1.0 / 60.0, "looks wrong", "its header has [s]"),
    ],
)
def test_the_unit_that_a_clock_has_is_named(written: str, scale: float, words: str, remedy: str) -> None:
    """By the unit that the header states; where no unit would be right, what to do with the numbers."""
    trials = [replace(t, time=t.time * scale, time_unit=written) for t in recorded(off(TWO, 3), seed=1)]
    (fault,) = faults(run.check(project(TWO, trials)))
    assert words in fault.text
    assert remedy in fault.remedy


def test_the_unit_of_a_file_s_clock_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    rows = "\n".join(f"{k * 10},{30 + k % 3},{40 - k % 2}" for k in range(20))
    file.write_text(f"time [ms],hip [deg],knee [deg]\n{rows}\n")
    read = read_recording(file, TWO)
    assert read.time_unit == "ms"
    assert read.time[1] == pytest.approx(0.01)


def test_too_few_samples_and_coarse_counts_are_named() -> None:
    trials = recorded(off(TWO, 3), seed=1, noise=1e-6)
    few = [replace(t, time=t.time[::12], angles=t.angles[::12]) for t in trials]
    assert any("samples per period" in each.text for each in run.check(project(TWO, few)).findings)
    count = np.radians(3.0)
    coarse = [replace(t, angles=np.round(t.angles / count) * count) for t in trials]
    assert any("one count is 3 deg" in each.text for each in run.check(project(TWO, coarse)).findings)


def test_a_late_channel_is_measured() -> None:
    late = with_effects(TWO, {"knee": {"latency": {"delay": 0.02}}})
    found = run.check(project(TWO, recorded(late, noise=np.radians(0.02))))
    lag = next(each for each in found.lags if each.joint == "knee")
    assert lag.late.value == pytest.approx(0.02, rel=0.25)
    assert any("later than the other channels" in each.text and each.joint == "knee" for each in found.findings)


def test_recordings_that_are_compared_in_pieces_are_checked_whole(tmp_path: Path) -> None:
    """In a piece a joint may hold still while another moves, which would be a frozen channel of a recording."""
    found = run.check(turned_over(tmp_path, {}, 0, (1.2, 2.2), 5.0, 3))
    assert any("compared in" in finding.text for finding in found.findings)
    assert found.sentence.startswith("3 recordings can be used")
    assert [one.name for one in found.recordings] == ["0.csv", "1.csv", "2.csv"]


def test_the_command_answers_first_and_writes_only_where_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["gap", "--check", str(EXAMPLE / "gap.yaml"), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert said.splitlines()[0].startswith("7 recordings can be used")
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"check.json", "report.html"}
    assert "Inseparable causes" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["gap.yaml"], "--out is missing"),
        (["gap.yaml", "--check", "--dry-run"], "exclude each other"),
        (["none.yaml", "--check"], "none.yaml"),
    ],
)
def test_a_project_that_cannot_be_checked_gives_one_message(
    words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(EXAMPLE, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    before = sorted(tmp_path.rglob("*"))
    assert main(["gap", *words]) == 2
    assert message in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared cases are not here")
@pytest.mark.parametrize(
    ("scale", "named"), [(1000.0, "Is the time in another unit?"), pytest.param(1.0, "", marks=pytest.mark.slow)]
)
def test_milliseconds_labelled_s_are_refused_by_name(
    scale: float, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "case"
    shutil.copytree(SHARED / "skdqbm9z", case)
    file = case / "trials" / "02.csv"
    head, *rows = file.read_text().splitlines()
    changed = [f"{float(row.split(',')[0]) * scale:.6f},{row.partition(',')[2]}" for row in rows]
    file.write_text("\n".join([head, *changed]) + "\n")
    status = main(["gap", "--check", str(case / "gap.yaml")])
    captured = capsys.readouterr()
    assert status == (2 if named else 0)
    if named:
        assert "02.csv" in captured.err
        assert named in captured.err
