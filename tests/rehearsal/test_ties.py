"""Ties in a rehearsal: what the diagnosis cannot distinguish is neither found nor mistaken."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from diagnosis.simulated_releases import TWO, recorded
from rehearsal.test_rehearsal import outcome, project
from synth.commands.gap_rehearse import rehearsal_text
from synth.planting.refusals import NotApplicable, TooSmall
from synth.rehearsal.one_case import _reason
from synth.rehearsal.outcome import CaseOutcome
from synth.rehearsal.rehearsal_result import RehearsalResult
from synth.rehearsal.rehearse import Rehearsal, _RunProgress
from synth.rehearsal.users_rig import Rig, users_rig
from synth.reports import write_rehearsal_report

SHIFTED, SCALED, LATE = ("spring_preload", "knee"), ("encoder_scale", "knee"), ("latency", "hip")


def diagnosed_as(effect: str, *explanations: tuple[tuple[str, str], ...]) -> CaseOutcome:
    """A large cause at the knee, or none for "", which the diagnosis explains in one of these ways."""
    made = outcome(
        effect, 1 if effect else 0, 2 if effect else 0, False, verdict="effect" if len(explanations) == 1 else "tie"
    )
    named = tuple(dict.fromkeys(key for each in explanations for key in each))
    return replace(made, named=named, explanations=explanations, planted=made.planted if effect else None)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return users_rig(project(TWO, recorded(TWO)))


def test_what_was_planted_beside_the_main_cause_is_not_tied_with_it() -> None:
    """Dry friction, planted beside, and an alias of it stood among the causes that an offset cannot be told from."""
    rubs, loads = ("coulomb_friction", "hip"), ("load_friction", "hip")
    tie = diagnosed_as("spring_preload", (loads, SHIFTED), (SHIFTED, rubs), (SCALED, loads))
    assert replace(tie, small=(rubs,)).tied_with == ("encoder_scale (knee)",)
    without = diagnosed_as("spring_preload", (SCALED, rubs), (SHIFTED, loads))
    assert replace(without, small=(rubs,)).tied_with == ("encoder_scale (knee)",)


def test_a_cause_too_small_to_plant_is_not_said_not_to_act(rig: Rig, tmp_path: Path) -> None:
    """A heavier link that acts, but not as much as asked for within its limits, "cannot act here"."""
    small = replace(diagnosed_as("link_mass", ()), verdict="cannot", explanations=None, named=())
    said: list[str] = []
    Rehearsal(tmp_path / "gap.yaml", rig, 3, 1, 2, {})._tell_outcome(small.task, small, _RunProgress(1), said.append)
    assert said == ["  1/1 link mass (knee), 10 times the remainder: cannot be planted as large"]
    none = replace(small, message="the joint has no spring")  # a reason of its own
    assert none.taken_for == "cannot be planted: the joint has no spring"
    assert _reason(TooSmall("link_mass: 2 floors at most")) == ""
    assert _reason(NotApplicable("the joint has no spring")) == none.message


def test_a_tie_is_counted_apart_and_not_as_a_name(rig: Rig, tmp_path: Path) -> None:
    """Planted in second place of "cannot distinguish them", a cause was "named", with a smallest size."""
    tie = diagnosed_as("spring_preload", (SCALED,), (SHIFTED,))
    assert (tie.right, tie.tied, tie.tied_with) == (False, True, ("encoder_scale (knee)",))
    assert CaseOutcome.from_json(json.loads(json.dumps(tie.as_json()))) == tie
    found = RehearsalResult("leg", rig, 0, (tie,), {}).as_json()
    (cause,) = found["causes"]
    assert {k: cause[k] for k in ("named", "tied", "large_named", "large_tied")} == {
        "named": 0, "tied": 1, "large_named": 0, "large_tied": 1,
    }  # fmt: skip
    assert cause["visible_from"] is None
    assert cause["tied_with"] == {"encoder_scale (knee)": 1}
    assert cause["taken_for"] == {}
    assert found["confusion"][0]["diagnoses"] == {"tied with others": 1}
    assert "is found in 0 of 1 and tied with others in 1; 0 of 1 causes" in found["sentence"]
    assert "found at some size, 1 more only tied with others" in found["sentence"]
    text = rehearsal_text(found)
    assert "spring preload  tied (1 of 1)" in text
    assert "not distinguished from:\n- spring preload (knee): encoder scale (knee)" in text
    said: list[str] = []
    Rehearsal(tmp_path / "gap.yaml", rig, 3, 1, 2, {})._tell_outcome(tie.task, tie, _RunProgress(1), said.append)
    assert said == ["  1/1 spring preload (knee), 10 times the remainder: tied with encoder scale (knee)"]
    (tmp_path / "rehearsal.json").write_text(json.dumps(found))
    page = write_rehearsal_report(tmp_path).read_text()
    assert "encoder scale (knee) ×1" in page
    assert "tied with others" in page


def test_what_all_tied_explanations_hold_is_named() -> None:
    """As the diagnosis says: this, and either that or that. One of the others may be absent."""
    both = diagnosed_as("spring_preload", (SHIFTED, SCALED), (SHIFTED, LATE))
    assert (both.right, both.tied, both.with_absent, both.taken_for) == (True, False, False, "spring_preload (knee)")
    assert diagnosed_as("spring_preload", (SHIFTED, LATE)).with_absent
    without = diagnosed_as("spring_preload", (SCALED,), (LATE,))
    assert (without.right, without.tied, without.diagnosis) == (False, False, "tie of others")
    assert without.taken_for == "tie of encoder_scale (knee), latency (hip)"


def test_a_tie_of_absent_causes_is_a_false_alarm() -> None:
    assert not diagnosed_as("", (SCALED,), (LATE,)).tied
    partly = replace(diagnosed_as("", (SCALED,), (LATE,)), small=(LATE,))
    assert (partly.right, partly.tied) == (False, True)
    assert replace(partly, small=(LATE, SCALED)).right
