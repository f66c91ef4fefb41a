"""Rehearsals of legs whose file states dry friction or drag: the generator's forms beside the other engine's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehearsal.test_rehearsal import TWO, project, recorded
from synth.files.gap_project import read_gap_project
from synth.files.leg_file import write_leg
from synth.fit.recordings import recordings
from synth.planting import torque_laws
from synth.planting.model import Law, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.simulation import release
from synth.planting.stated_friction import all_laws
from synth.rehearsal.case_files import write_case
from synth.rehearsal.one_case import diagnose_apart
from synth.rehearsal.outcome import named_causes
from synth.rehearsal.plants import Field, PlantingTask, cause_places
from synth.rehearsal.users_rig import users_rig
from synth.swing.chain import simulate

STATED: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "dry friction that holds": {"coulomb_friction": {"torque": 0.01}},
    "dry friction with a deflection": {"coulomb_friction": {"torque": 0.01, "presliding": 2e-3}},
    "dry friction that falls with speed": {"stribeck_friction": {"torque": 0.012, "fall": 0.4, "speed": 0.6}},
    "drag": {"quadratic_damping": {"coefficient": 4e-4}},
}


@pytest.mark.parametrize("name", STATED)
def test_a_leg_with_a_stated_effect_moves_as_in_the_other_engine(name: str) -> None:
    leg = TWO.with_joints(knee={"effects": STATED[name]})
    given = project(leg, recorded(leg))
    rig = users_rig(given)
    for recording, trial, times in zip(recordings(leg, given.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        at = trial.pose, trial.speed, times
        ours, plain = (simulate(each, *at, recording.conditions) for each in (leg, TWO))
        theirs = release(Truth(rig.nominal), trial, 1e-4).at(times)
        left, whole = (float(np.sqrt(np.mean((ours - other) ** 2))) for other in (theirs, plain))
        assert left < 0.05 * whole


def test_a_cause_that_sticks_adds_to_the_stated_friction() -> None:
    """Two rigid constraints of one joint would each hold against the whole torque."""
    dry, falling = (
        Law(torque_laws.STICK_SLIP, 1, (0.1, 0.1, 1.0, 0.0)),
        Law(torque_laws.STICK_SLIP, 1, (0.2, 0.5, 0.3, 2.0)),
    )
    gear, bearing = Law(torque_laws.GEAR, 1, (0.2, 0.0)), Law(torque_laws.BEARING, 1, (2e-3, 0.0))
    rubbing = users_rig(project(TWO.with_joints(knee={"effects": STATED["drag"]}), recorded(TWO))).nominal

    def beside(stated: Law, *causes: Law) -> tuple[Law, ...]:
        return all_laws(replace(rubbing, laws=(stated,)), causes)

    assert beside(dry, falling) == beside(falling, dry)
    (both,) = beside(dry, falling)
    assert both.par == pytest.approx((0.3, 0.6, 0.3, 2.0))
    assert beside(dry, gear) == (gear._replace(par=(0.2, 0.1)),)
    assert beside(bearing, dry, dry) == (bearing._replace(par=(2e-3, 0.2)),)
    assert beside(gear, gear) == (gear._replace(par=(0.4, 0.0)),)
    elsewhere = dry._replace(joint=0)
    assert beside(dry, elsewhere) == (dry, elsewhere)
    with pytest.raises(NotApplicable, match="another dry friction"):
        beside(falling, gear)


@pytest.mark.slow  # like ``test_rehearsal``
def test_more_friction_than_stated_is_planted_and_found(tmp_path: Path) -> None:
    leg = TWO.with_joints(knee={"effects": STATED["dry friction that holds"]})
    write_leg(leg, tmp_path / "two.leg.yaml")
    entries = []
    for number, trial in enumerate(recorded(leg, seed=2, noise=np.radians(0.01))):
        heads = ",".join(["time [s]", *(f"{name} [deg]" for name in leg.joint_names)])
        table = np.column_stack([trial.time, np.degrees(trial.angles)])
        np.savetxt(tmp_path / f"{number}.csv", table, "%.9g", ",", header=heads, comments="")
        entries.append(f"{number}.csv")
    (tmp_path / "gap.yaml").write_text(f"kind: gap\nleg: two.leg.yaml\ntrials: [{', '.join(entries)}]\n")
    given = read_gap_project(tmp_path / "gap.yaml")
    rig = users_rig(given)
    assert ("coulomb_friction", 1) in cause_places(rig, 1)
    planted = Field.of(rig, 3, 0).plant(np.random.default_rng(2), PlantingTask("coulomb_friction", 1, 3, 0))
    (tmp_path / "case").mkdir()
    case = write_case(given, rig, planted, tmp_path / "case")
    document, said = diagnose_apart(case, tmp_path / "out", [])
    assert document is not None, said
    assert named_causes(document)[0] == ("coulomb_friction", "knee")
    told = next(c for c in document["explanation"] if c["effect"] == "coulomb_friction")
    assert told["parameters"]["torque"]["value"] == pytest.approx(0.01 + planted.answer["causes"][0]["size"], rel=0.1)
