"""Recordings of different sample rates in one fit: each counts as much as its own samples tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from synth.files.trial_list import Trial
from synth.fit.early_misfit import LaterScatter
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.least_squares import FitStart
from synth.fit.recordings import Recording, recordings
from synth.fit.refinement import refine
from synth.fit.starts import first_locals, weak_form_start
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LEG = Leg("leg", (Joint("knee", Link(0.2, 0.7, 0.09, 3.5e-3), spring=Spring(4.0, 0.3), damper=Damper(0.02)),))
LASTING = 0.02  # s, correlation time of the noise
SLOW, DENSE = 0.02, 0.002  # s, sample steps
OPTIONS = LegFitOptions("common")


def recorded(seed: int, steps: Sequence[float]) -> list[Recording]:
    """Releases of ``steps`` s between samples, with noise of 0.3 deg whose correlation decays with ``LASTING``."""
    generator, made = np.random.default_rng(seed), []
    for number, step in enumerate(steps):
        time = np.arange(0.0, 1.5, step)
        start = (0.9, 0.7, -0.5, -0.8, 0.6, -0.7)[number % 6]
        rotation = simulate(LEG, np.array([start]), np.zeros(1), time, tolerance=1e-8)
        decay = np.exp(-step / LASTING)
        noise = generator.normal(size=len(time)) * np.append(1.0, np.full(len(time) - 1, np.sqrt(1.0 - decay**2)))
        for i in range(1, len(noise)):
            noise[i] += decay * noise[i - 1]
        made.append(Trial(f"t{number}", time, LEG.to_measured(rotation) + np.radians(0.3) * noise[:, None]))
    return recordings(LEG, made)


def test_each_rate_has_its_own_noise() -> None:
    """Dense samples are more correlated, 20 against 2.2; sparse ones were taken to tell as little as they."""
    made = recorded(0, [SLOW] * 6 + [DENSE] * 2)
    model = model_of(LEG, recordings=made)
    start = FitStart(weak_form_start(model, made, OPTIONS).values, first_locals(made))
    noise = refine(model, made, start, "noise", np.zeros(1)).weights.noise[:, 0]
    assert np.ptp(noise[:6]) == np.ptp(noise[6:]) == 0.0
    decays = np.exp(-np.array([DENSE, SLOW]) / LASTING)
    wanted = np.radians(0.3) * np.sqrt((1.0 + decays) / (1.0 - decays))
    assert noise[[6, 0]] == pytest.approx(wanted, rel=0.25)
    later = LaterScatter.of(made, [one.rotation + np.radians(0.3) for one in made])
    assert later.deviation.shape == (8, 1)
