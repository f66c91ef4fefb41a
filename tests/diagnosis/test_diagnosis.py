"""The whole diagnosis: scoring, copies, order of input, ties and the trial that resolves them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, HANGING, NOISE, TWO, causes, off, recorded, shifted, with_effects
from synth import units
from synth.diagnosis.diagnosis_result import PHASES, Experiment
from synth.diagnosis.plants.swinging_chain import chain_diagnosis
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.diagnosis.plants.swinging_chain.chain_write import write_gap
from synth.diagnosis.verdict import UNKNOWN_IF_CONTRADICTED
from synth.errors import UserError
from synth.files.gap_project import GapProject, Tolerance
from synth.files.trial_list import Trial, read_trials
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg

BUILT = with_effects(off(TWO, 4), {"knee": {"quadratic_damping": {"coefficient": 0.006}}})


@lru_cache(maxsize=1)
def found() -> GapResult:
    """The diagnosis that most tests here look at, one trial held out."""
    return diagnose(TWO, recorded(BUILT, seed=2), Tolerance())


def content(result: GapResult) -> str:
    """The whole result without the trials' names."""
    document = result.as_json()
    for key in ("warnings", "remarks", "inputs"):
        document.pop(key)
    document["gap"].pop("scored_on")
    return json.dumps(document, sort_keys=True)


def written(result: GapResult, folder: Path) -> dict[str, bytes]:
    """The files, by name."""
    folder.mkdir()
    write_gap(result, GapProject(Path("gap.yaml"), "leg", TWO, (), Tolerance(), 0, (), ()), folder)
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_the_same_trials_give_the_same_bytes(tmp_path: Path) -> None:
    again = diagnose(TWO, recorded(BUILT, seed=2), Tolerance())
    one, two = written(found(), tmp_path / "one"), written(again, tmp_path / "two")
    tables = {"predicted/3.csv", "where/3.csv", "alone/3.csv"}
    assert set(one) == {"gap.json", "designed.leg.yaml", "diagnosed.leg.yaml", "page.json"} | tables
    assert one == two


def test_only_held_out_trials_are_scored_where_there_are_any() -> None:
    assert found().scored_on == ("3.csv",)
    assert [trial.name for trial in found().trials if trial.scored] == ["3.csv"]


def test_held_out_trials_change_neither_the_causes_nor_their_ratios() -> None:
    """Spoilt ones change the score, and so how sure it is that the cause is in the library."""
    trials = recorded(BUILT, seed=2)
    spoilt = [replace(t, angles=t.angles + 0.2 * t.held_out) for t in trials]
    result = diagnose(TWO, spoilt, Tolerance())
    assert result.explanation == found().explanation
    assert [entry.cause for entry in result.ranked] == [entry.cause for entry in found().ranked]
    known = (1.0 - result.probability_unknown) / (1.0 - found().probability_unknown)
    expected = [known * entry.probability for entry in found().ranked]
    assert [entry.probability for entry in result.ranked] == pytest.approx(expected)
    assert result.after.value > 5.0 * found().after.value
    assert result.shrink.value < 0.25
    assert (found().verdict, result.verdict) == ("effect", "unknown")


def test_without_held_out_trials_each_is_predicted_by_the_others() -> None:
    """Of two trials each is predicted from the other alone: worse than by a fit that has seen it."""
    trials = [replace(t, held_out=False) for t in recorded(BUILT, AWAY[:2], seed=2)]
    result = diagnose(TWO, trials, Tolerance())
    assert result.scored_on == ("0.csv", "1.csv")
    assert causes(result)[0] == ("quadratic_damping", "knee")
    assert result.shrink.value > 0.8
    (seen,) = diagnose(TWO, [*trials[1:], replace(trials[0], held_out=True)], Tolerance()).trials
    in_turn, by_other = result.trials[0].after, seen.after
    assert np.sqrt(np.mean((in_turn - by_other) ** 2)) < 0.3 * NOISE  # the closed form is a fit of the other


def test_copies_do_not_count_twice() -> None:
    trials = recorded(BUILT, seed=2)
    copy = replace(trials[0], name="copy.csv")
    seen = replace(trials[1], name="seen.csv", held_out=True)  # not unseen: it was learnt from
    result = diagnose(TWO, [*trials, copy, copy, seen], Tolerance())
    assert content(result) == content(found())
    assert result.scored_on == found().scored_on
    assert sum("is a copy of" in warning for warning in result.warnings) == 3


def test_the_order_of_columns_does_not_matter(tmp_path: Path) -> None:
    read: list[list[Trial]] = []
    for order in ([0, 1], [1, 0]):
        folder = tmp_path / f"{order[0]}"
        folder.mkdir()
        for trial in recorded(BUILT, seed=2):
            table = np.column_stack([trial.time, np.degrees(trial.angles)[:, order]])
            header = ",".join(["time [s]", *(f"{TWO.joint_names[j]} [deg]" for j in order)])
            np.savetxt(folder / trial.name, table, delimiter=",", header=header, comments="", fmt="%.12g")
        entries = ["[0-2].csv", {"file": "3.csv", "held_out": True}]
        read.append(list(read_trials(entries, folder, TWO)))
    for one, other in zip(*read, strict=True):
        np.testing.assert_array_equal(one.angles, other.angles)
    assert causes(diagnose(TWO, read[1], Tolerance())) == causes(found())


def test_all_held_out_is_refused() -> None:
    with pytest.raises(UserError, match="every trial is held out"):
        diagnose(TWO, [replace(t, held_out=True) for t in recorded(BUILT)], Tolerance())


def test_a_trial_with_a_locked_joint_informs_about_the_others() -> None:
    locked = recorded(BUILT, AWAY[:1], conditions=Conditions((0,)), held_out=0, seed=8, first=9)
    result = diagnose(TWO, [*recorded(BUILT, seed=2), *locked], Tolerance())
    assert causes(result) == [("quadratic_damping", "knee")]


def test_free_torques_are_those_of_the_leg_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(leg: Leg, nominal: Leg, *rest: object) -> tuple[Leg]:
        return (nominal,)

    monkeypatch.setattr(chain_diagnosis, "free_torques", made)
    scene, _ = chain_diagnosis.scene_of(TWO, recorded(TWO), Tolerance(), 0)
    plant = chain_diagnosis.SwingingChain(scene, ())
    first, second = plant.designed(), plant.designed().at(np.ones(plant.n_tolerance))
    heavy = plant.free_torques(second)
    assert plant.free_torques(first) == (TWO,)
    assert plant.free_torques(second) is heavy  # computed once
    assert heavy != (TWO,)


def test_shares_sum_to_one_over_all_joints_and_phases() -> None:
    where = found().where
    assert set(where.joint) == set(TWO.joint_names)
    assert set(where.phase) == set(PHASES)
    for shares in (where.joint, where.phase, where.speed, where.position, where.load, where.time):
        assert sum(shares.values()) == pytest.approx(1.0)
        assert min(shares.values()) >= 0.0
    assert where.joint["knee"] > 0.9


def is_number(value: object) -> bool:
    """``{"value": 1.71, "unit": "N*m/rad"}``, with ``interval90`` where it is an estimate, around its value."""
    if not isinstance(value, Mapping) or not {"value", "unit"} <= set(value) <= {"value", "unit", "interval90"}:
        return False
    low, high = value.get("interval90", [value["value"], value["value"]])
    return isinstance(value["unit"], str) and low <= value["value"] <= high


def test_gap_json_follows_the_format(tmp_path: Path) -> None:
    gap: dict[str, Any] = json.loads(written(found(), tmp_path / "out")["gap.json"])
    assert gap["format"] == "synth/gap/1"
    assert gap["verdict"] == "effect"
    for cause in [*gap["explanation"], *gap["ranked"]]:
        assert cause["joint"] in (*TWO.joint_names, "base")
        for value in cause["parameters"].values():
            assert is_number(value), value
    low, high = gap["explanation"][0]["parameters"]["coefficient"]["interval90"]
    assert low < high
    for entry in gap["ranked"]:
        assert set(entry) == {"effect", "joint", "probability", "parameters", "shrink"}
        assert 0.0 <= entry["probability"] <= 1.0
        assert entry["shrink"]["value"] <= 1.0
        assert len(entry["shrink"]["interval90"]) == 2
    assert [e["probability"] for e in gap["ranked"]] == sorted((e["probability"] for e in gap["ranked"]), reverse=True)
    total = sum(entry["probability"] for entry in gap["ranked"])
    assert total + gap["probability_none"] + gap["probability_unknown"] <= 1.0 + 1e-9
    for shares in (gap["where"]["joint"], gap["where"]["phase"]):
        assert sum(shares.values()) == pytest.approx(1.0)
    for name in ("as_designed", "before", "after", "noise_floor"):
        assert is_number(gap["gap"][name])
        assert gap["gap"][name]["unit"] == "deg"
        assert (name == "noise_floor") or "interval90" in gap["gap"][name]
    assert gap["gap"]["scored_on"] == ["3.csv"]
    assert isinstance(gap["next_experiment"]["why"], str)
    assert isinstance(gap["next_experiment"]["trial"], dict)


def test_predictions_are_written_beside_the_measurement(tmp_path: Path) -> None:
    files = written(found(), tmp_path / "out")
    assert sorted(name for name in files if name.startswith("predicted/")) == ["predicted/3.csv"]
    header, *rows = files["predicted/3.csv"].decode().splitlines()
    kinds = [f"{joint} {kind} [deg]" for joint in TWO.joint_names for kind in ("measured", "before", "after")]
    assert header.split(",") == ["time [s]", *kinds]
    table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    measured, before, after = table[:, 4], table[:, 5], table[:, 6]
    assert np.sqrt(np.mean((after - measured) ** 2)) == pytest.approx(0.1, rel=0.2)
    assert np.sqrt(np.mean((before - measured) ** 2)) > 0.5


# A tie and its end


def proposed_trial(built: Leg, experiment: Experiment) -> Trial:
    """The trial that was asked for, made with the built leg."""
    entry = experiment.trial
    conditions = Conditions(
        tuple(built.joint_names.index(name) for name in entry.get("locked", [])),
        units.parse(entry["tip_mass"], "kg") if "tip_mass" in entry else 0.0,
        units.parse(entry["tilt"], "rad") if "tilt" in entry else 0.0,
    )
    pose = built.to_rotation(np.array([experiment.release[name] for name in built.joint_names]))
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) for j in built.joints if j.spring])
    (trial,) = recorded(built, (pose - rest)[None, :], conditions=conditions, held_out=0, seed=77, first=50)
    return trial


@pytest.mark.parametrize(
    ("truth", "joint"),
    [("spring_preload", "knee"), pytest.param("base_tilt", "base", marks=pytest.mark.slow)],
    ids=["preload", "tilt"],
)
def test_the_proposed_trial_resolves_a_tie(truth: str, joint: str) -> None:
    """A pendulum that hangs askew: a preloaded spring, a base that is not level, or an encoder that is off?"""
    leg = off(HANGING, 1)
    built = shifted(leg, "knee", 0.1) if truth == "spring_preload" else replace(leg, tilt=0.1)
    trials = recorded(built, seed=2)
    result = diagnose(HANGING, trials, Tolerance())
    assert result.verdict == "tie"
    named = {causes(result)[0], *((c.effect, c.joint) for option in result.tied for c in option)}
    assert (truth, joint) in named
    assert len(named) > 1
    experiment = result.next_experiment
    assert experiment is not None
    assert "tilt" in experiment.trial or "tip_mass" in experiment.trial
    assert experiment.information > 1.0
    assert list(experiment.menu) == sorted(experiment.menu, key=lambda item: -item[1])
    after = diagnose(HANGING, [*trials, proposed_trial(built, experiment)], Tolerance())
    assert after.verdict == "effect"
    assert causes(after) == [(truth, joint)]
    assert after.ranked[0].probability > max(0.75, 2.0 * result.ranked[0].probability)


def test_an_uninformative_trial_leaves_the_tie() -> None:
    """The information belongs to that trial: one more release like the others resolves nothing."""
    built = shifted(off(HANGING, 1), "knee", 0.1)
    trials = [*recorded(built, seed=2), *recorded(built, AWAY[:1], held_out=0, seed=70, first=50)]
    assert diagnose(HANGING, trials, Tolerance()).verdict == "tie"


@pytest.mark.slow  # half a minute
def test_a_cause_that_unseen_trials_contradict_is_unknown_and_the_trials_are_named() -> None:
    """The friction of the trials learnt from is gone in the held-out one, which the nominal leg predicts better."""
    rubbing = with_effects(TWO, {"knee": {"coulomb_friction": {"torque": 0.15}}})
    learnt = recorded(rubbing, held_out=0)[:3]
    (free,) = recorded(TWO)[3:]
    result = diagnose(TWO, [*learnt, free], Tolerance())
    alone = result.ranked[0].shrink
    assert alone is not None
    assert alone.high is not None
    assert alone.high < 0.0
    assert result.shrink.value == 0.0  # what remains is what the nominal leg leaves, not what the friction adds to it
    assert result.as_json()["explanation"] == []
    assert result.verdict == "unknown"
    assert result.probability_unknown == pytest.approx(
        UNKNOWN_IF_CONTRADICTED, abs=0.005
    )  # the limit: sure by all blocks of it
    assert [text for text in result.warnings if free.name in text and "no better" in text]
    sure = diagnose(TWO, [*learnt, replace(recorded(rubbing)[3], held_out=True)], Tolerance())
    assert sure.verdict != "unknown"
