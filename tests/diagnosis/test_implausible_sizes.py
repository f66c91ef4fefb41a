"""A cause whose smallest visible size is absurd is not one that recordings could show."""

from __future__ import annotations

from dataclasses import replace
from math import degrees

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, recorded
from diagnosis.test_gap_check import project, showing
from synth.commands.gap_check import _size
from synth.diagnosis.check import run
from synth.reports.openings.check_opening import cause_size
from synth.swing.leg_model import Damper, Spring

AWAY = np.array([[0.5], [-0.4], [0.7]])


@pytest.mark.parametrize(("spring", "damper", "plausible"), [(1e-4, 1e-4, False), (1e-3, 1e-3, True)])
def test_backlash_before_almost_no_spring_and_damper_does_not_count(
    spring: float, damper: float, plausible: bool
) -> None:
    """A play of 36 deg, in a swing of 40, before a damper of 1e-4 N m s/rad was one of the causes that could show."""
    (joint,) = ONE.joints
    leg = replace(ONE, joints=(replace(joint, spring=Spring(spring, 1.8), damper=Damper(damper)),))
    found = run.check(project(leg, recorded(leg, AWAY, held_out=0)))
    play = showing(found, "backlash", "knee")
    told = play.as_json()
    assert f"show {sum(each.visible_from is not None for each in found.showings)} of" in found.sentence
    if plausible:
        assert play.visible_from is not None
        assert play.only_from is None
        assert "implausible" not in _size(told) + cause_size(told)
        return
    assert play.visible_from is None
    assert play.only_from is not None
    least = degrees(play.only_from["gap"].value)
    assert least > 3.0 * degrees(0.15 * 0.5)  # three deviations of its prior, in the smallest swing's size
    assert _size(told) == f"only from {least:.0f} deg, implausible"
    assert cause_size(told).startswith(f"only from {least:.1f}")
    assert all(("backlash", "knee") not in cluster.keys for cluster in found.clusters)
