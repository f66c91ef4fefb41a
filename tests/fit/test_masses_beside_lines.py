"""Fits of legs whose centres of mass lie beside the lines of their links, recorded by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fit.simulated_legs import Rig, bare, errors, releases, robot
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg

ACROSS = (0.03, -0.02, 0.015)  # m


def with_sides(leg: Leg, across: tuple[float, float, float]) -> Leg:
    links = [replace(j.link, com_across=x) for j, x in zip(leg.joints, across, strict=True)]
    return replace(leg, joints=tuple(replace(j, link=link) for j, link in zip(leg.joints, links, strict=True)))


def test_the_fit_with_the_sides_finds_the_leg_and_the_fit_without_them_does_not() -> None:
    true = with_sides(robot(), ACROSS)
    trials, off = releases(true, 1, Rig(noise=0.02, counts=0)), []
    for given in (bare(true), with_sides(bare(true), (0.0, 0.0, 0.0))):
        missed = errors(fit_leg(given, recordings(given, trials), LegFitOptions()), true)
        off.append(float(np.abs(np.r_[missed.spring, missed.damper, missed.angle]).max()))
    assert off[0] < 0.01
    assert off[1] > 0.1
