"""Rehearsals: the generator moves a user's leg as the other engine does, answers closed, finished cases reused."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import Context
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, recorded
from synth.batch.folder import RunCheckpoint
from synth.batch.task_outcome import TaskOutcome
from synth.cli import main
from synth.commands.gap_rehearse import rehearsal_text
from synth.compiling.announced import told_to
from synth.errors import UserError
from synth.files.gap_project import GapProject, Tolerance, read_gap_project
from synth.files.leg_file import write_leg
from synth.files.trial_list import Trial
from synth.planting.model import Truth
from synth.planting.simulation import release
from synth.rehearsal import one_case, rehearse
from synth.rehearsal.case_files import write_case
from synth.rehearsal.ladder import next_rung, visible_from
from synth.rehearsal.one_case import CaseCall, diagnose_apart, plant_and_diagnose
from synth.rehearsal.outcome import CANNOT, FAILED, CaseOutcome, explanations_of, named_causes
from synth.rehearsal.plants import RUNGS, Field, Planted, PlantingTask, cause_places
from synth.rehearsal.rehearsal_result import RehearsalResult
from synth.rehearsal.rehearse import Rehearsal
from synth.rehearsal.users_rig import BACKGROUND_SHARE, Rig, load_engine, users_rig
from synth.reports import write_rehearsal_report
from synth.reports.openings.rehearsal_opening import rehearsal_opening
from synth.reports.reading import read_result
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, DamperCurve, Leg

TIME = np.arange(151) * 0.01
CURVE = DamperCurve((1.0, 4.0, 12.0), (0.1, 0.25, 0.4))
ODD = TWO.with_joints(hip={"damper": Damper(curve=CURVE), "armature": 3e-3}, knee={"armature": 1e-3})


def project(leg: Leg, trials: list[Trial], path: Path = Path("gap.yaml")) -> GapProject:
    return GapProject(path, leg.name, leg, tuple(trials), Tolerance(), 0, (), ())


def driven() -> list[Trial]:
    """Releases at speed, with a tip mass off the link's end, a tilt, a joint held, and a torque denser than angles."""
    moments = np.arange(0.0, 1.501, 0.004)
    torque = np.zeros((len(moments), 2))
    torque[:, 1] = 0.3 * np.sin(9.0 * moments) * np.sign(np.sin(4.0 * moments))
    start = np.array([0.5, -0.4])
    made = []
    for locked, mass, tilt in (((), 0.05, 0.0), ((0,), 0.0, 0.3)):
        conditions = Conditions(locked, mass, tilt, 1e-4 if mass else 0.0, 0.1 if mass else None)
        speed = np.array([1.0, -2.0]) * [j not in locked for j in range(2)]
        motion = simulate(ODD, start, speed, TIME, conditions, known_torque=(moments, torque))
        everything = np.unique(np.concatenate([moments, TIME]).round(9))
        angles = np.full((len(everything), 2), np.nan)
        angles[np.searchsorted(everything, TIME.round(9))] = ODD.to_measured(motion[:, :2])
        known = np.stack([np.interp(everything, moments, t) for t in (ODD.sign * torque).T], axis=1)
        names = tuple(ODD.joint_names[j] for j in locked)
        made.append(
            Trial(
                f"{len(made)}.csv",
                everything,
                angles,
                torques=known,
                locked=names,
                tip_mass=mass,
                tilt=tilt,
                tip_inertia=conditions.tip_inertia,
                tip_at=conditions.tip_at,
            )
        )
    return made


def test_the_generator_moves_a_user_s_leg_as_the_other_engine_does() -> None:
    """Two engines, one leg: measured dampers, rotors, tip masses, tilts, locks, torques and speeds at the start."""
    rig = users_rig(project(ODD, driven()))
    for number, trial in enumerate(rig.trials):
        motion = release(Truth(rig.nominal), trial, 1e-4)
        conditions = Conditions(trial.locked, trial.tip_mass, trial.tilt, trial.tip_inertia, trial.tip_at)
        assert trial.speed is not None
        ours = simulate(ODD, trial.pose, trial.speed, rig.times[number], conditions, known_torque=trial.known)
        np.testing.assert_allclose(motion.at(rig.times[number]), ours[:, :2], atol=2e-5)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return users_rig(project(TWO, recorded(TWO, seed=2, noise=np.radians(0.01))))


@pytest.fixture(scope="module")
def field(rig: Rig) -> Field:
    return Field.of(rig, 5, 0)


def plant(field: Field, task: PlantingTask) -> Planted:
    planted = field.plant(np.random.default_rng(1), task)
    assert planted is not None
    return planted


def test_a_planted_case_has_the_gap_of_its_step_and_further_small_causes(field: Field) -> None:
    found = plant(field, PlantingTask("coulomb_friction", 1, 2, 0)).answer
    (cause,) = found["causes"]
    assert cause["gap"] == pytest.approx(RUNGS[2] * np.hypot(field.ground.floor, found["small_gap"]), rel=0.13)
    assert cause["size"] > 0.0
    assert len(found["small"]) == 3
    assert field.rig.background == pytest.approx(BACKGROUND_SHARE * 0.25, rel=0.6)  # swings of about 0.25 rad RMS
    assert found["small_gap"] == pytest.approx(field.rig.background, rel=0.3)


def test_the_small_causes_together_decide_whether_the_noise_hides_them(rig: Rig) -> None:
    """Each alone below the noise, all were left out, while the page told of them and sizes were set beside them."""
    own = replace(rig, background=1.3 * Field.of(rig, 5, 0).ground.floor)
    field = Field.of(own, 5, 0)
    found = plant(field, PlantingTask("coulomb_friction", 1, 1, 0)).answer
    assert len(found["small"]) == 3
    assert found["small_gap"] == pytest.approx(own.background, rel=0.3)
    assert found["causes"][0]["gap"] == pytest.approx(3.0 * np.hypot(field.ground.floor, found["small_gap"]), rel=0.13)
    hidden = Field.of(replace(rig, background=0.9 * field.ground.floor), 5, 0)
    found = plant(hidden, PlantingTask("coulomb_friction", 1, 1, 0)).answer
    assert (found["small"], found["small_gap"]) == ([], 0.0)
    assert found["causes"][0]["gap"] == pytest.approx(3.0 * field.ground.floor, rel=0.13)


def test_the_page_tells_what_was_planted_beside(rig: Rig, tmp_path: Path) -> None:
    bare = outcome("coulomb_friction", 1, 2, True)
    beside = replace(bare, small=(("latency", "hip"),), small_gap=np.radians(0.05))
    nothing = replace(outcome("", 0, 0, False, verdict="none"), planted=None)
    said = []
    for made in (
        [bare, nothing],
        [beside, replace(nothing, small=beside.small, small_gap=beside.small_gap)],
        [bare, beside],
    ):
        content = RehearsalResult("leg", rig, 0, tuple(made), {}).as_json()
        (tmp_path / "rehearsal.json").write_text(json.dumps(content))
        page = write_rehearsal_report(tmp_path).read_text().replace("\u00a0", " ")
        said.append(page + content["sentence"])
    assert "no small causes beside (1 % of the motion" in said[0]
    assert "With noise only, an absent" in said[0]
    assert "up to 1 small causes beside that leave 0.05" in said[1]
    assert "With small causes only, an absent" in said[1]
    assert "small causes beside in 1 of 2 that leave" in said[2]


def test_a_case_has_the_user_s_trials_and_does_not_reveal_its_answer(field: Field, tmp_path: Path) -> None:
    trials = recorded(TWO, seed=2, noise=np.radians(0.01))
    write_leg(TWO, tmp_path / "my.leg.yaml")
    (tmp_path / "gap.yaml").write_text("kind: gap\nleg: my.leg.yaml\ntrials: [a.csv]\ntolerance: {mass: 2 %}\n")
    planted = plant(field, PlantingTask("spring_preload", 0, 2, 0))
    (tmp_path / "case").mkdir()
    own = project(TWO, trials, tmp_path / "gap.yaml")
    case = read_gap_project(write_case(own, field.rig, planted, tmp_path / "case"))
    assert case.tolerance.mass == pytest.approx(0.02)
    assert [trial.held_out for trial in case.trials] == [trial.held_out for trial in trials]
    for trial, before, reading in zip(case.trials, trials, planted.readings, strict=True):
        np.testing.assert_allclose(trial.time, before.time, atol=1e-9)
        np.testing.assert_allclose(trial.angles, reading, atol=1e-8)
    text = "".join(file.read_text() for file in (tmp_path / "case").rglob("*") if file.is_file())
    assert "preload" not in text


def test_torques_of_a_case_are_the_user_s(tmp_path: Path) -> None:
    own = project(ODD, driven(), tmp_path / "gap.yaml")
    (tmp_path / "gap.yaml").write_text("kind: gap\nleg: my.leg.yaml\ntrials: [a.csv]\n")
    rig = users_rig(own)
    readings = tuple(
        rig.nominal.reading(release(Truth(rig.nominal), t, 1e-3).at(x))
        for t, x in zip(rig.trials, rig.times, strict=True)
    )
    (tmp_path / "case").mkdir()
    again = users_rig(read_gap_project(write_case(own, rig, Planted(readings, {}), tmp_path / "case")))
    for first, second in zip(rig.trials, again.trials, strict=True):
        assert first.known is not None
        assert second.known is not None
        for joint in range(2):
            told = np.interp(first.known[0], second.known[0], second.known[1][:, joint])
            np.testing.assert_allclose(told, first.known[1][:, joint], atol=1e-8)
        assert (first.tip_mass, first.tip_inertia, first.tip_at) == pytest.approx(
            (second.tip_mass, second.tip_inertia, second.tip_at)
        )


def outcome(effect: str, joint: int, rung: int, right: bool, draw: int = 0, verdict: str = "") -> CaseOutcome:
    key = (effect, "knee")
    said = verdict or ("effect" if right else "none")
    named = (key,) if right else ()
    return CaseOutcome(
        PlantingTask(effect, joint, rung, draw),
        key,
        "form",
        0.01 * (rung + 1),
        0.1 * (rung + 1),
        (),
        said,
        named,
        0.9,
    )


def test_the_bisection_finds_the_smallest_visible_size_and_restarts() -> None:
    """A cause that is named from a rung on: two or three cases find the rung, whichever it is."""
    for least in range(len(RUNGS) + 1):
        made: list[CaseOutcome] = []
        for _ in range(10):
            rung, draw = next_rung(made)
            if draw:
                break
            made.append(outcome("backlash", 1, rung, rung >= least))
        assert len(made) <= 3
        assert visible_from(made) == (least if least < len(RUNGS) else None)
    above = [outcome("backlash", 1, 1, False), outcome("backlash", 1, 2, False, verdict=CANNOT)]
    assert next_rung(above) == (1, 1)  # an impossible cause has no rung


def test_one_success_at_a_small_size_does_not_make_it_visible() -> None:
    lucky = [outcome("backlash", 1, 0, True), outcome("backlash", 1, 1, False), outcome("backlash", 1, 1, False, 1)]
    assert visible_from([*lucky, outcome("backlash", 1, 2, True)]) == 2


def test_the_causes_named_by_a_gap_file() -> None:
    cause = {"effect": "backlash", "joint": "knee"}
    other = {"effect": "latency", "joint": "hip"}
    document = {"verdict": "tie", "ranked": [other, cause], "explanation": [cause], "tied": [[other]]}
    assert named_causes(document) == (("latency", "hip"), ("backlash", "knee"))
    assert named_causes(document | {"verdict": "unknown"}) == ()
    assert explanations_of(document) == ((("backlash", "knee"),), (("latency", "hip"),))


def test_a_diagnosis_can_open_neither_answers_nor_generator(tmp_path: Path) -> None:
    write_leg(TWO, tmp_path / "my.leg.yaml")
    document, said = diagnose_apart(tmp_path / "gap.yaml", tmp_path / "out", [tmp_path])
    assert document is None
    assert "closed to a diagnosis" in said or "is closed" in said


class Fake:
    """Replaces the processes: answers at once, and is interrupted after some cases."""

    def __init__(self, until: int) -> None:
        self.until, self.made = until, 0

    def __call__(
        self, function: Any, calls: Iterable[tuple[str, CaseCall]], workers: int
    ) -> Iterator[tuple[str, TaskOutcome]]:
        assert function is plant_and_diagnose
        for name, call in calls:
            if self.made == self.until:
                raise KeyboardInterrupt
            self.made += 1
            task = call.task
            key = (task.effect, "knee") if task.effect else None
            right = task.rung >= 1
            made = CaseOutcome(
                task, key, "", 0.01, 0.1, (), "effect" if right else "none", (key,) if right and key else (), 0.9
            )
            yield name, TaskOutcome(value=made.as_json())


def rehearsal(rig: Rig, folder: Path, count: int = 40) -> Rehearsal:
    return Rehearsal(folder / "gap.yaml", rig, 3, count, 2, {"gap.yaml": "x"})


def test_an_interrupted_rehearsal_resumes_to_the_same_result(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(rehearse, "run_here", Fake(10**6))
    whole = rehearsal(rig, tmp_path)
    whole.run(RunCheckpoint(tmp_path / "a", "rehearsal", "words"), {}, said.append)
    assert len(whole.outcomes) == 40
    assert said[-1].startswith("  40/40 ")
    assert any("min left" in line or "s left" in line for line in said)

    stopped, fake = rehearsal(rig, tmp_path), Fake(13)
    monkeypatch.setattr(rehearse, "run_here", fake)
    with pytest.raises(KeyboardInterrupt):
        stopped.run(RunCheckpoint(tmp_path / "b", "rehearsal", "words"), {}, said.append)
    rest = Fake(10**6)
    monkeypatch.setattr(rehearse, "run_here", rest)
    going = rehearsal(rig, tmp_path)
    going.run(RunCheckpoint(tmp_path / "b", "rehearsal", "words"), {}, said.append)
    assert fake.made + rest.made == 40
    assert [o.task for o in going.outcomes] == [o.task for o in whole.outcomes]

    more, few = Fake(10**6), rehearsal(rig, tmp_path, 50)
    monkeypatch.setattr(rehearse, "run_here", more)
    few.run(RunCheckpoint(tmp_path / "c", "rehearsal", "words"), {o.task.name: o for o in whole.outcomes}, said.append)
    assert len(few.outcomes) == 50
    assert more.made < 50


class SometimesKilled(Fake):
    """Answers as ``Fake`` does, but the diagnosis of one case is killed at first."""

    def __init__(self) -> None:
        super().__init__(10**6)
        self.killed = ""

    def __call__(self, *words: Any) -> Iterator[tuple[str, TaskOutcome]]:
        for name, ended in super().__call__(*words):
            if not self.killed and ended.value["effect"]:
                self.killed = name
                yield name, TaskOutcome(value=ended.value | {"verdict": FAILED, "message": "killed by SIGKILL"})
            else:
                yield name, ended


def test_a_failed_diagnosis_is_told_and_made_again(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was stored, reused for ever, and counted as a cause that was not found."""
    fake, said = SometimesKilled(), list[str]()
    monkeypatch.setattr(rehearse, "run_here", fake)
    first, kept = rehearsal(rig, tmp_path, 12), RunCheckpoint(tmp_path / "a", "rehearsal", "words")
    first.run(kept, {}, said.append)
    assert not kept.has(fake.killed, first.identity)
    assert any(line.partition(";")[0].endswith("failed: killed by SIGKILL") for line in said)
    found = RehearsalResult("leg", rig, 3, tuple(first.outcomes), {}).as_json()
    told = "1 diagnosis failed and is not counted: killed by SIGKILL. The same command again repeats only what failed."
    assert found["sentence"].endswith(told)
    assert told in found["warnings"]
    assert "seconds" not in found["plants"][0]

    earlier = {o.task.name: o for o in first.outcomes}
    for kept_cases, before in ((kept, {}), (RunCheckpoint(tmp_path / "b", "rehearsal", "words"), earlier)):
        again, whole = Fake(10**6), rehearsal(rig, tmp_path, 12)
        monkeypatch.setattr(rehearse, "run_here", again)
        whole.run(kept_cases, before, said.append)
        assert 1 <= again.made < 12
        assert all(o.verdict != FAILED for o in whole.outcomes)


def test_a_cause_whose_diagnoses_failed_is_neither_found_nor_missed(rig: Rig) -> None:
    failed = outcome("backlash", 1, 1, False, verdict=FAILED)
    assert next_rung([failed]) == (1, 1)  # the same size with the next draw
    found = RehearsalResult("leg", rig, 0, (failed, outcome("coulomb_friction", 1, 2, True)), {})
    assert "1 of 1 causes that were planted were found" in found.sentence


def test_a_killed_diagnosis_says_by_which_signal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(one_case, "PACKAGE", tmp_path)
    (tmp_path / "commands").mkdir()
    (tmp_path / "commands" / "watched.py").write_text("import os; os.kill(os.getpid(), 9)")
    assert diagnose_apart(tmp_path / "gap.yaml", tmp_path / "out", []) == (None, "killed by SIGKILL")


def test_a_result_has_sizes_confusions_and_false_alarms(rig: Rig) -> None:
    outcomes = [
        outcome("coulomb_friction", 1, 1, False),
        outcome("coulomb_friction", 1, 2, True),
        replace(outcome("backlash", 1, 2, False, verdict="effect"), named=(("one_sided_spring", "knee"),)),
        replace(outcome("", 0, 0, False, verdict="none"), planted=None),
        replace(outcome("", 0, 0, False, 1, verdict="effect"), planted=None, named=(("latency", "hip"),)),
        outcome("cogging", 1, 2, False, verdict="unknown"),
        outcome("spring_preload", 0, 1, False, verdict="cannot"),
    ]
    found = RehearsalResult("leg", rig, 0, tuple(outcomes), {}).as_json()
    by_effect = {cause["effect"]: cause for cause in found["causes"]}
    assert by_effect["coulomb_friction"]["visible_from"]["value"] == pytest.approx(0.3)
    assert by_effect["coulomb_friction"]["visible_from"]["unit"] == "N*m"
    assert by_effect["backlash"]["visible_from"] is None
    assert by_effect["backlash"]["taken_for"] == {"one_sided_spring (knee)": 1}
    assert found["nothing_planted"] == {
        "cases": 2,
        "right": 1,
        "tied": 0,
        "with_small": 0,
        "taken_for": {"latency (hip)": 1},
    }
    assert found["not_in_the_library"]["right"] == 1
    assert "named in 1 of 2" in found["sentence"]
    assert "1 of 2 causes that were planted were found at some size." in found["sentence"]
    left = len(cause_places(rig, 0)) - 3
    assert found["coverage"] == f"Not planted: {left} further causes that may act in this leg."
    all_of_them = [outcome(effect, max(joint, 0), 2, True) for effect, joint in cause_places(rig, 0)]
    names = {-1: "base", **dict(enumerate(rig.nominal.names))}
    planted = [
        replace(made, planted=(effect, names[joint]))
        for made, (effect, joint) in zip(all_of_them, cause_places(rig, 0), strict=True)
    ]
    sentence = RehearsalResult("leg", rig, 0, tuple(planted), {}).sentence
    assert f" of {len(planted)} causes that can act in this leg were found" in sentence
    assert RehearsalResult("leg", rig, 0, tuple(planted), {}).coverage == ""
    assert sentence
    assert json.dumps(found, allow_nan=False)


def test_joints_stand_in_the_leg_s_order_and_a_miss_with_its_cases(rig: Rig, tmp_path: Path) -> None:
    """The first effect by name was planted at the knee alone: the knee stood before the hip."""
    outcomes = (
        outcome("backlash", 1, 2, False, verdict="none"),
        outcome("coulomb_friction", 1, 2, True),
        replace(outcome("latency", 0, 2, False, verdict="none"), planted=("latency", "hip")),
        replace(outcome("latency", 0, 1, False, 1, verdict="none"), planted=("latency", "hip")),
    )
    content = RehearsalResult("leg", rig, 0, outcomes, {}).as_json()
    text = rehearsal_text(content).split("smallest size found:")[1]
    assert re.search(r"^ +hip +knee$", text, re.MULTILINE)
    assert re.search(r"^backlash +- +not found \(0 of 1\)$", text, re.MULTILINE)
    assert re.search(r"^latency +not found \(0 of 2\) +-$", text, re.MULTILINE)
    (tmp_path / "rehearsal.json").write_text(json.dumps(content))
    figures = rehearsal_opening(read_result(tmp_path, "rehearsal.json", "rehearsal")).figures
    assert figures is not None
    assert figures.heads == ("Smallest size found", "hip", "knee")
    shown = {row[0].text: [(cell.text, cell.small) for cell in row[1:]] for row in figures.rows}
    assert shown["backlash"] == [("–", ""), ("not found", "0 of 1")]
    assert shown["latency"][0] == ("not found", "0 of 2")


def test_the_opening_of_a_rehearsal_has_every_cause_that_was_found(rig: Rig, tmp_path: Path) -> None:
    """Latency alone stood there, and the headline began with what was not planted."""
    effects = ("latency", "armature", "quadratic_damping", "spring_hysteresis")
    outcomes = [outcome(effect, 1, 1, True) for effect in effects]
    outcomes.append(outcome("viscous_damping", 1, 1, False, verdict="none"))
    result = RehearsalResult("leg", rig, 0, tuple(outcomes), {})
    content = result.as_json()
    (tmp_path / "rehearsal.json").write_text(json.dumps(content))
    opening = rehearsal_opening(read_result(tmp_path, "rehearsal.json", "rehearsal"))
    assert opening.verdict.startswith("4 of 5 causes that were planted were found at some size.")
    assert opening.trust.startswith("Not planted: any cause with a gap of 10 times the unexplained remainder; ")
    assert opening.figures is not None
    names = [row[0].text for row in opening.figures.rows]
    assert names == ["latency", "armature", "quadratic damping", "spring hysteresis", "viscous damping"]
    assert result.coverage in rehearsal_text(content)


def test_every_cause_that_can_act_is_rehearsed(rig: Rig) -> None:
    found = cause_places(rig, 0)
    assert len(found) == len(set(found))
    assert ("base_tilt", -1) in found
    assert {("backlash", 0), ("backlash", 1)} <= set(found)
    assert not [key for key in found if key[0].startswith("torque_")]


def test_a_leg_with_an_effect_of_another_form_is_refused() -> None:
    rubbing = TWO.with_joints(knee={"effects": {"backlash": {"play": 0.02}}})
    with pytest.raises(UserError, match=r"knee: the leg file gives it backlash; .* it has coulomb_friction"):
        users_rig(project(rubbing, recorded(TWO)))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--count", "3"], "--count applies to --rehearse only"),
        (["--rehearse", "--check"], "exclude each other"),
        (["--rehearse", "--count", "0"], "0"),
        (["--rehearse"], "--out is missing"),
        (["--keep", "cases"], "--keep applies to --rehearse only"),
    ],
)
def test_impossible_requests_give_one_message(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = [] if message.startswith("--out") else ["--out", str(tmp_path / "out")]
    example = Path(__file__).resolve().parents[2] / "synth" / "examples" / "gap" / "gap.yaml"
    assert main(["gap", str(example), *words, *out]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_one_case_from_end_to_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written_project(tmp_path)
    words = ["gap", "--rehearse", str(tmp_path / "gap.yaml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main([*words, "--count", "1"]) == 0
    first = json.loads((tmp_path / "out" / "rehearsal.json").read_text())
    assert first["plants"][0]["verdict"] in ("effect", "tie", "none", "unknown")
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Smallest sizes found" in page
    assert "0 of 0" not in page  # of kinds of which none was planted
    assert "if large, diagnosed as" not in page
    capsys.readouterr()
    assert main([*words, "--count", "1"]) == 0  # nothing is left to do, and nothing is done
    assert "reusing finished cases of the same input files" in capsys.readouterr().out
    assert json.loads((tmp_path / "out" / "rehearsal.json").read_text())["plants"] == first["plants"]
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_planted_noise_went_through_the_filter_of_the_user_s(tmp_path: Path) -> None:
    """A mean of nine readings: a quarter of its noise was planted, and that independent."""
    rng, made = np.random.default_rng(3), []
    for trial in recorded(TWO, seed=2, noise=0.0, time=np.arange(0.0, 2.0, 0.005)):
        wide = np.radians(0.3) * rng.standard_normal((len(trial.time) + 8, 2))
        shaken = np.stack([np.convolve(column, np.full(9, 1 / 9), "valid") for column in wide.T], axis=1)
        made.append(replace(trial, angles=np.radians(np.round(np.degrees(trial.angles + shaken), 5))))
    own = replace(users_rig(project(TWO, made)), background=0.0)
    np.testing.assert_allclose(np.degrees(own.noise), 0.1, rtol=0.15)
    field = Field.of(own, 5, 0)
    readings = plant(field, PlantingTask("", 0, 0, 0)).readings
    clean = [field.ground.setup.true.reading(m.at(t)) for m, t in zip(field.ground.plain, own.times, strict=True)]
    noise = np.concatenate([(a - b)[None] for a, b in zip(readings, clean, strict=True)])
    assert np.degrees(np.std(noise)) == pytest.approx(0.1, rel=0.15)
    assert np.mean(noise[:, 1:] * noise[:, :-1]) / np.mean(noise**2) == pytest.approx(8 / 9, abs=0.04)
    content = RehearsalResult("leg", own, 0, (outcome("backlash", 1, 2, True),), {}).as_json()
    assert content["noise_filters"] == dict.fromkeys(TWO.joint_names, "a mean of 9 readings")
    (tmp_path / "rehearsal.json").write_text(json.dumps(content))
    assert "as behind a mean of 9 readings" in write_rehearsal_report(tmp_path).read_text()


def test_the_truth_of_a_case_has_the_built_leg_and_every_cause(field: Field) -> None:
    """Only the main size stood there: neither the built leg nor the sizes of the small causes."""
    answer = plant(field, PlantingTask("coulomb_friction", 1, 2, 0)).answer
    main, *beside = answer["truth"]["causes"]
    assert [main["effect"], main["size"]] == ["coulomb_friction", answer["causes"][0]["size"]]
    assert [[each["effect"], each["joint"]] for each in beside] == answer["small"]
    assert all(each["numbers"] for each in (main, *beside))
    built = field.ground.setup.true
    for joint, values in answer["truth"]["leg"].items():
        for name, pair in values.items():
            assert pair["built"] == built.of(name)[built.names.index(joint)]
            assert pair["designed"] == field.rig.nominal.of(name)[built.names.index(joint)] != pair["built"]
    assert set(answer["truth"]["leg"]["knee"]) >= {"mass", "spring", "free_angle"}
    assert json.dumps(answer, allow_nan=False)
    told = replace(outcome("coulomb_friction", 1, 2, True), truth=answer["truth"])
    assert CaseOutcome.from_json(json.loads(json.dumps(told.as_json()))) == told


def written_project(folder: Path) -> Path:
    write_leg(TWO, folder / "my.leg.yaml")
    (folder / "trials").mkdir()
    for trial in recorded(TWO, seed=2, noise=np.radians(0.01), held_out=0):
        rows = [f"{t:.6f},{a:.6f},{b:.6f}" for t, (a, b) in zip(trial.time, np.degrees(trial.angles), strict=True)]
        (folder / "trials" / trial.name).write_text("\n".join(["time [s],hip [deg],knee [deg]", *rows]) + "\n")
    (folder / "gap.yaml").write_text("kind: gap\nleg: my.leg.yaml\ntrials: [trials/*.csv]\n")
    return folder / "gap.yaml"


def test_a_case_is_kept_and_a_failed_one_told_by_the_exit_status(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The folder of a case was deleted: a confusion could not be looked at. A rehearsal without a diagnosis ended 0."""
    here = [(None, "killed by SIGKILL"), ({"verdict": "none", "ranked": []}, "")]
    monkeypatch.setattr(one_case, "diagnose_apart", lambda *given: here.pop())

    def run_in_turn(function: Any, calls: Any, workers: int) -> Iterator[tuple[str, TaskOutcome]]:
        for name, call in calls:
            yield name, TaskOutcome(value=Context().run(function, call))  # as another process, it may write elsewhere

    monkeypatch.setattr(rehearse, "run_here", run_in_turn)
    words = ["gap", "--rehearse", str(written_project(tmp_path)), "--out", str(tmp_path / "out")]
    words += ["--count", "2", "--workers", "1"]
    kept = tmp_path / "cases"
    assert main([*words, "--keep", str(kept)]) == 1
    assert "1 diagnosis failed and is not counted" in capsys.readouterr().out
    plants = json.loads((tmp_path / "out" / "rehearsal.json").read_text())["plants"]
    assert sorted(path.name for path in kept.iterdir()) == sorted(each["name"] for each in plants)
    for each in plants:
        assert read_gap_project(kept / each["name"] / "gap.yaml").trials
        assert json.loads((kept / each["name"] / "truth.json").read_text())["truth"] == each["truth"]
    again = tmp_path / "again"
    here[:] = [({"verdict": "none", "ranked": []}, "")]  # the failed one is made again, the other only written
    assert main([*words, "--keep", str(again)]) == 0
    assert here == []
    for each in plants:
        for file in (kept / each["name"] / "trials").iterdir():
            assert file.read_bytes() == (again / each["name"] / "trials" / file.name).read_bytes()


def test_the_engine_is_compiled_once_and_says_so(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Minutes passed in silence, in each worker."""
    said: list[str] = []

    @contextmanager
    def stage(text: str) -> Iterator[None]:
        said.append(text)
        yield

    load_engine(rig)
    with told_to(stage):
        load_engine(rig)
        assert said == []
        monkeypatch.setattr("synth.rehearsal.users_rig.kept_code", lambda module: False)
        load_engine(rig)
    assert "compiling the engine that simulates the planted causes (once on this machine" in said[0]
