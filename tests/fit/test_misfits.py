"""A motion that springs and dampers cannot follow is said so first; noise that lasts is not taken for one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from synth.arrays import Array
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import recordings
from synth.remarks import severity_of
from synth.swing.leg_model import Joint, Leg, Link

INERTIA, SPRING, DAMPER = 8.76e-3, 2.0, 0.05
LEG = Leg("leg", (Joint("knee", Link(0.3, 0.4, 0.12, INERTIA - 0.4 * 0.12**2)),), gravity=0.0)
TIME = np.arange(0.0, 1.2, 0.005)


def found(relaxing: float, lasting: float) -> list[str]:
    """What three releases tell: a muscle's torque that fades with 0.4 s, as a share of the swing; noise of 50 ms."""
    generator, trials = np.random.default_rng(3), []
    decay = 0.5 * DAMPER / INERTIA
    swing = math.sqrt(SPRING / INERTIA - decay**2)
    wave = np.exp(-decay * TIME) * (np.cos(swing * TIME) + decay / swing * np.sin(swing * TIME))
    for start in (27.0, 28.0, 29.0):
        # A torque exp(-t/0.4) moves the joint in proportion to itself, beside a free swing.
        angle = 30.0 + start * (wave + relaxing * np.exp(-TIME / 0.4))
        angle += 0.1 * generator.normal(size=len(TIME)) + lasting * lasting_noise(generator)
        trials.append(Trial(f"t{start}", TIME, np.radians(angle)[:, None]))
    options = LegFitOptions("common", release="recorded", laws="linear")
    return [text for text in fit_leg(LEG, recordings(LEG, trials), options).warnings if "the residual is" in text]


def lasting_noise(generator: np.random.Generator) -> Array:
    """(n,) of deviation 1 that decays with 50 ms."""
    share, noise = math.exp(-0.1), generator.normal(size=len(TIME))
    for i in range(1, len(noise)):
        noise[i] = share * noise[i - 1] + math.sqrt(1.0 - share**2) * noise[i]
    return noise


@pytest.mark.parametrize(("relaxing", "lasting", "decides"), [(0.3, 0.0, True), (0.0, 0.6, False)])
def test_only_a_motion_that_is_not_followed_is_not_to_be_used(relaxing: float, lasting: float, decides: bool) -> None:
    (text,) = found(relaxing, lasting)
    assert (severity_of(text) == "decide") == decides
    assert ("cannot follow this motion: the numbers here and at the joints beside it" in text) == decides
