"""A joint that is locked in every trial: its reading and its link can still be wrong."""

from __future__ import annotations

from diagnosis.simulated_releases import AWAY, TWO, heavier, off, recorded, with_effects
from diagnosis.test_recovery import one_of
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions

HIP, KNEE = Conditions(locked=(0,)), Conditions(locked=(1,))


def keys(conditions: Conditions) -> set[tuple[str, str]]:
    """What is tried of a leg with a joint locked."""
    trials = recorded(TWO, AWAY[:2], conditions=conditions, held_out=0)
    given = [angle_trial(r, held_out=False) for r in recordings(TWO, trials, ())]
    return {candidate.key for candidate in candidates(TWO, given, natural_sizes_of(TWO, given))}


def test_effects_visible_at_a_locked_joint_are_candidates() -> None:
    hip_locked, knee_locked = keys(HIP), keys(KNEE)
    assert ("encoder_offset", "hip") in hip_locked
    assert ("encoder_offset", "knee") in knee_locked
    assert ("link_mass", "knee") in knee_locked
    assert ("link_mass", "hip") not in hip_locked  # the thigh stands still, whatever it weighs
    for effect in ("coulomb_friction", "spring_preload", "latency", "backlash"):
        assert (effect, "hip") not in hip_locked
        assert (effect, "knee") not in knee_locked


def test_encoder_offset_at_a_locked_joint_ties_with_base_tilt() -> None:
    """The knee swings as it would with the base turned: only a trial with the hip free could tell."""
    built = with_effects(off(TWO, 4), {"hip": {"encoder_offset": {"offset": 0.15}}})
    result = diagnose(TWO, recorded(built, seed=2, conditions=HIP), Tolerance())
    assert result.verdict == "tie"
    assert one_of(result, "encoder_offset", "hip")
    assert one_of(result, "base_tilt", "base")
    found = {(e.cause.effect, e.cause.joint): e.cause.parameters for e in result.ranked}
    assert abs(found["encoder_offset", "hip"]["offset"].value - 0.15) < 0.03
    assert abs(found["base_tilt", "base"]["tilt"].value + 0.15) < 0.03


def test_a_heavier_link_beyond_a_locked_joint_is_found() -> None:
    built = heavier(off(TWO, 4), "knee", 0.4)
    result = diagnose(TWO, recorded(built, seed=2, conditions=KNEE), Tolerance())
    assert one_of(result, "link_mass", "knee") or one_of(result, "link_inertia", "knee")
