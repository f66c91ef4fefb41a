"""The start of a search for another law: the weak form with the law's torque beside spring and damper.

From the fit of springs and linear dampers alone, steps towards a strong law end in another minimum: with dry friction
of a fifth of a joint's torque, 0.01 for 0.2 N m. The weak form has none but its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of, unknowns_of
from synth.fit.joint_laws import JointLaw, with_law
from synth.fit.least_squares import FitStart, Solution, Stage
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.starts import WINDOWS, first_locals, quick_costs
from synth.fit.trajectories import TrajectoryModel
from synth.fit.weak_form import LinearEstimate, WeakForm
from synth.swing.leg_model import Leg
from synth.swing.mechanics import outboard_inertia

LEAST_DECAY = 0.5  # 1/s of b/I, in the recordings' unit of time, where the weak form leaves no damper beside the law


def law_starts(
    law: JointLaw, leg: Leg, recordings: Sequence[Recording], options: LegFitOptions, stage: Stage
) -> Iterator[tuple[Array, Stage]]:
    """Coefficients (n,) of the law from the weak form, and all else fitted beside them; the likeliest window first.

    ``stage`` : the fit without the law to the same recordings. Its values are kept where the weak form has none.
    """
    weak = WeakForm(leg, recordings, [options.curves.get(name) for name in leg.joint_names], law.power)
    tried: list[tuple[float, Array, TrajectoryModel, FitStart]] = []
    shifts = np.array([local.shift for local in stage.solution.locals])
    locals_ = [replace(own, shift=shift) for own, shift in zip(first_locals(recordings), shifts, strict=True)]
    for window in WINDOWS:
        found = weak.solve(window * recordings[0].unit)[0]
        assert found.law is not None
        size = np.where(found.law > 0.0, found.law, 0.0)
        if not size.any():
            continue
        given = with_law(leg, law, size)
        model = model_of(given, options.curves, recordings=recordings, prior=options.prior, static=options.static)
        values = _values(model, found, stage.solution, recordings[0].unit)
        cost = float(quick_costs(model, recordings, [values], [shifts])[0])
        tried.append((cost, size, model, FitStart(values, locals_)))
    for cost, size, model, start in sorted(tried, key=lambda each: each[0]):
        if np.isfinite(cost):
            weights = stage.weights
            begun = refine(model, recordings, start, options.weight, weights.spread, points=weights.points)
            if np.isfinite(begun.solution.cost):
                yield size, begun


def _values(model: TrajectoryModel, found: LinearEstimate, fitted: Solution, unit: float) -> Array:
    """(p,) common unknowns by the weak form, those of ``fitted`` at a joint where it has none.

    ``unit`` : s, of the recordings.
    """
    sought = unknowns_of(model)
    leg = sought.fitted_leg(fitted.values)
    usable = np.isfinite(found.spring_rate) & (found.spring_rate > 0.0) & np.isfinite(found.rest)
    rate = np.where(usable, found.spring_rate, leg.spring_rate)
    rest = np.where(usable, found.rest, [joint.rest for joint in leg.joints])
    damping = np.where(usable, found.damper_rate, 0.0)
    packed = sought.pack(rate, rest, np.maximum(damping, LEAST_DECAY / unit * outboard_inertia(leg)))
    kept = np.concatenate([~usable[list(each)] for each in (sought.rates, sought.rests, sought.dampers)])
    return np.where(kept, fitted.values, packed)
