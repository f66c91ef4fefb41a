"""The generator's properties: floors, strengths, valid files that do not reveal the answer, reproducibility by seed."""

from __future__ import annotations

import ast
import json
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from blind.cases import Case, make_case
from blind.make import main, plan
from blind.writing import write_case
from synth.files.leg_file import read_leg
from synth.files.trial_list import read_trials
from synth.planting.effect_makers import EFFECTS
from synth.planting.explained_gap import PlainModel
from synth.planting.model import Array
from synth.planting.unlisted_effects import UNLISTED_EFFECTS

HERE = Path(__file__).parent
PLANTING = HERE.parents[1] / "synth" / "planting"


@pytest.fixture(scope="module")
def friction() -> Case:
    return make_case(3, 0, "single", "coulomb_friction", 3.0)


@pytest.fixture(scope="module")
def nothing() -> Case:
    return make_case(3, 1, "none")


def left(case: Case) -> float:
    """RMS (floors) that the nominal leg within its tolerances leaves on the given recordings, including noise."""
    floor = math.radians(case.answer["noise_floor_deg"])
    model, leg = PlainModel(case.setup, floor, case.states), case.setup.true
    targets: list[Array] = []
    for i, (times, reading) in enumerate(zip(case.times, case.readings, strict=True)):
        picked = np.searchsorted(times, model.times[i] - 1e-9)
        rotation = (reading - leg.zero) * leg.sign
        for j in range(leg.n):
            missing = np.isnan(rotation[:, j])
            rotation[missing, j] = np.interp(times[missing], times[~missing], rotation[~missing, j])
        targets.append(rotation[picked])
    return model.fit(targets, case.states).rms / floor


def test_without_an_effect_the_tolerances_leave_the_noise(nothing: Case) -> None:
    assert nothing.answer["effects"] == []
    assert left(nothing) == pytest.approx(1.0, abs=0.04)


def test_an_effect_leaves_a_gap_of_its_strength(friction: Case) -> None:
    strength = friction.answer["effects"][0]["strength"]
    assert left(friction) == pytest.approx(math.hypot(strength, 1.0), rel=0.06)


def test_the_floor_is_noise_and_counts(friction: Case) -> None:
    setup = friction.setup
    expected = math.degrees(math.hypot(setup.noise, 2 * math.pi / setup.counts / math.sqrt(12)))
    assert friction.answer["noise_floor_deg"] == pytest.approx(expected, rel=0.03)
    assert friction.answer["best_possible_deg"] == pytest.approx(expected, rel=0.06)
    assert friction.answer["before_deg"] > 1.5 * expected


def test_the_design_is_off_within_tolerance_in_every_case(friction: Case, nothing: Case) -> None:
    for case in (friction, nothing):
        ratio = case.setup.nominal.values[:6] / case.setup.true.values[:6]
        assert np.all(ratio != 1.0)
        assert np.all(np.abs(ratio - 1) < 0.15)
        shift = np.degrees(case.setup.nominal.of("free_angle") - case.setup.true.of("free_angle"))
        assert np.all((shift != 0) & (np.abs(shift) < 1.3))


@pytest.mark.parametrize("number", [0, 1])
def test_files_are_valid_and_do_not_reveal_the_answer(
    number: int, friction: Case, nothing: Case, tmp_path: Path
) -> None:
    case = (friction, nothing)[number]
    write_case(case, tmp_path / "abc", "abc")
    leg = read_leg(tmp_path / "abc" / "nominal.leg.yaml")
    project = yaml.safe_load((tmp_path / "abc" / "gap.yaml").read_text())
    trials = read_trials(project["trials"], tmp_path / "abc", leg)
    assert leg.joint_names == case.setup.nominal.names
    assert [t.held_out for t in trials] == [t.held_out for t in case.setup.trials]
    assert sum(t.held_out for t in trials) >= 3
    for trial, reading in zip(trials, case.readings, strict=True):
        np.testing.assert_allclose(trial.angles, reading, atol=2e-7)
    for joint, (mass, rate) in zip(leg.joints, case.setup.nominal.values[[1, 4]].T.tolist(), strict=True):
        assert joint.link.mass == pytest.approx(mass, rel=1e-9)
        assert joint.spring is not None
        assert joint.spring.rate == pytest.approx(rate, rel=1e-9)
    files = [p for p in tmp_path.rglob("*") if p.is_file()]
    words = [*EFFECTS, *UNLISTED_EFFECTS, "stick", "Bouc", "strength", "answer", "effect"]
    for path in files:
        text = path.name + path.read_text()
        assert not [w for w in words if w in text]


def test_tied_causes_fit_alike() -> None:
    answer = make_case(7, 3, "tie").answer
    tied = answer["cannot_be_told_apart"]
    true = answer["effects"][0]
    assert [true["effect"], true["joint"]] in tied
    assert len(tied) >= 2
    assert max(answer["chi_squared_more"]) < 6


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        arguments = ["--out", str(tmp_path / folder), "--answers", str(tmp_path / f"{folder}.json")]
        assert main([*arguments, "--seed", "4", "--count", "2", "--kind", "single", "--effect", "encoder_offset"]) == 0
    ours, theirs = (sorted(p for p in (tmp_path / f).rglob("*") if p.is_file()) for f in ("a", "b"))
    assert [p.relative_to(tmp_path / "a") for p in ours] == [p.relative_to(tmp_path / "b") for p in theirs]
    assert all(p.read_bytes() == q.read_bytes() for p, q in zip(ours, theirs, strict=True))
    answers = json.loads((tmp_path / "a.json").read_text())
    assert (tmp_path / "b.json").read_text() == (tmp_path / "a.json").read_text()
    assert set(answers) == {p.name for p in (tmp_path / "a").iterdir()}


def test_answers_must_not_be_stored_with_the_cases(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--out", str(tmp_path), "--answers", str(tmp_path / "x.json"), "--seed", "1", "--count", "1"])
    assert "outside" in capsys.readouterr().err


def test_the_mix_is_as_specified_and_every_effect_has_its_turn() -> None:
    tasks = plan(1, 200, "mix", None)
    kinds = [kind for _, kind, _ in tasks]
    assert [kinds.count(k) for k in ("single", "none", "two", "unknown", "tie")] == [120, 24, 20, 20, 16]
    assert {e for _, k, e in tasks if k == "single"} == set(EFFECTS)
    assert {e for _, k, e in tasks if k == "unknown"} == set(UNLISTED_EFFECTS)


def test_nothing_is_shared_with_the_program_under_test() -> None:
    waiting, seen = ["blind.make"], set()
    while waiting:  # the generator: all that making cases imports (scoring reads the program's results)
        module = waiting.pop()
        seen.add(module)
        package, _, name = module.rpartition(".")
        tree = ast.parse(((HERE if package == "blind" else PLANTING) / f"{name}.py").read_text())
        imported = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                whole = node.module in ("blind", "synth.planting")
                imported |= {f"{node.module}.{a.name}" for a in node.names} if whole else {str(node.module)}
        own = [m for m in imported if m.startswith(("blind.", "synth.planting."))]
        others = [m for m in imported if m not in own]
        assert not [m for m in others if m.split(".")[0] in ("synth", "cad", "reports", "fit", "model", "effects")]
        waiting = [m for m in [*waiting, *own] if m not in seen]
    assert len(seen) > 10


def test_every_effect_of_a_leg_that_the_format_names_has_cases() -> None:
    springs = {"hardening_spring", "one_sided_spring", "spring_hysteresis", "backlash", "spring_preload", "joint_stop"}
    friction = {"coulomb_friction", "stribeck_friction", "load_friction", "shear_thinning_damping", "quadratic_damping"}
    sensors = {"encoder_offset", "encoder_scale", "encoder_quantisation", "latency"}
    bodies = {"link_mass", "link_inertia", "base_compliance", "base_tilt", "link_flexibility"}
    assert set(EFFECTS) == springs | friction | sensors | bodies
    assert not set(EFFECTS) & set(UNLISTED_EFFECTS)
