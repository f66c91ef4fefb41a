"""The check of causes that the leg file states: what shows is a change of the stated size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, TWO, recorded, with_effects
from diagnosis.test_gap_check import project, showing
from synth.commands.gap_check import _size
from synth.diagnosis.angle_search import as_designed, fit_nominal
from synth.diagnosis.check import run
from synth.diagnosis.check.cause_responses import VISIBLE_SIGNAL
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.files.gap_project import Tolerance
from synth.reports.openings.check_opening import cause_size
from synth.swing.leg_model import Leg

AWAY = np.array([[0.5], [-0.4], [0.7]])
BOTH = np.array([[0.5, 0.6], [-0.4, 0.7]])
STATED = {
    "friction": (ONE, AWAY, ("coulomb_friction", "knee"), {"torque": 0.03}, "N*m from the stated 0.03"),
    "late": (TWO, BOTH, ("latency", "knee"), {"delay": 0.02}, "ms from the stated 20"),
    "bend": (TWO, BOTH, ("link_flexibility", "hip"), {"stiffness": 25.0}, "N*m/rad from the stated 25"),
}


def stating(leg: Leg, key: tuple[str, str], given: Mapping[str, float]) -> Leg:
    return with_effects(leg, {key[1]: {key[0]: given}})


@pytest.mark.parametrize(("leg", "away", "key", "given", "words"), STATED.values(), ids=STATED)
def test_the_smallest_size_of_a_stated_effect_is_a_change_that_leaves_three_deviations(
    leg: Leg, away: np.ndarray, key: tuple[str, str], given: Mapping[str, float], words: str
) -> None:
    """It was 0: the probe took the stated effect away, and near 0 differed by all of it."""
    designed = stating(leg, key, given)
    noisy = recorded(designed, away, held_out=0)
    found = run.check(project(designed, noisy))
    shown = showing(found, *key)
    assert shown.visible_from is not None
    ((parameter, value),) = given.items()
    assert shown.designed[parameter].value == value
    change = shown.visible_from[parameter].value
    assert 0.0 < change < 0.5 * value
    assert _size(shown.as_json()).startswith("a change of ")
    assert _size(shown.as_json()).endswith(words)
    assert "from the stated" in cause_size(shown.as_json())
    still = recorded(stating(leg, key, {parameter: value + change}), away, noise=0.0, held_out=0)
    noise = scene_of(designed, noisy, Tolerance(), 0)[0].bench.noise
    bench = scene_of(designed, still, Tolerance(), 0)[0].bench
    sized = np.hypot(noise, run.UNEXPLAINED_SHARE * np.array([channel.motion for channel in found.channels]))
    fitted = fit_nominal(replace(bench, noise=sized), as_designed(replace(bench, noise=sized)))
    left = sum(float(r @ r) for r in fitted.residuals) + float(fitted.unknowns @ fitted.unknowns)
    assert np.sqrt(left) == pytest.approx(VISIBLE_SIGNAL, rel=0.3)


def test_a_stated_mount_is_told_by_what_the_file_states() -> None:
    """Not by the rocking that it states none of, which is tried first elsewhere."""
    designed = with_effects(TWO, {"base": {"base_compliance": {"stiffness": 400.0, "mass": 0.3}}})
    mount = showing(run.check(project(designed, recorded(designed, BOTH, held_out=0))), "base_compliance", "base")
    assert mount.visible_from is not None
    assert [*mount.visible_from] == [*mount.designed] == ["stiffness"]
    assert 0.0 < mount.visible_from["stiffness"].value < 200.0
