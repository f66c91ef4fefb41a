"""Table 3: does it matter that the thesis takes the free angles from the end of each release? A refit shows it.

The recordings are fitted by least squares once more with each release's free angles held where spring and weight
balance in its final pose, as in the thesis; all else is as in the fit that estimates them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.fit.fit_problem import model_of, unknowns_of
from synth.fit.fit_result import FitResult
from synth.fit.least_squares import FitStart
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.ridge import MISFIT, loose_joints, soften
from synth.fit.starts import balanced_rests, starts
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import clipped_rms, root_mean_square, sample_scatter
from synth.swing.leg_model import Leg
from synth.validation.comparison_table import listed, percent
from synth.validation.explanations import NEAR_DIFFERENCE, found_rates, ridge_sentence
from synth.validation.open_rates import family_of
from synth.validation.thesis_data import JOINTS

LEAST_SHARE = 0.1  # share of a difference below which nothing of it is explained


@dataclass(frozen=True)
class HeldAngleFit:
    """Rates (2, n) N m/rad and N m s/rad and residuals ``rms`` (n,) rad with the free angles of the releases' ends.

    ``loose`` : joints whose k and b the releases leave open along b/k.
    """

    rates: Array
    rms: Array
    loose: tuple[str, ...]


def fit_with_angles_of_ends(leg: Leg, recordings: Sequence[Recording], near: FitResult) -> HeldAngleFit:
    """Least squares with each release's free angles held where spring and weight balance in its final pose.

    Such a free angle is the final pose plus its weight over k. A spring that is unloaded in the final pose, beside a
    constant torque that holds the weight there, has the same torque whatever its k: both are known before the fit.

    Parameters
    ----------
    near : the fit that estimates the free angles, with whose springs and dampers this one starts.
    """
    begun = starts(recordings)
    ends = np.array([start.end for start in begun])
    weights = balanced_rests(leg, recordings, list(ends), np.ones((len(leg.joints), 1)))[:, :, 0] - ends
    held = [_with_torque(recording, weight) for recording, weight in zip(recordings, weights, strict=True)]
    free = model_of(leg, recordings=recordings)
    model = TrajectoryModel(free.chain, free.leg, replace(unknowns_of(free), rests=()), max_steps=free.max_steps)
    spring, damper = found_rates(near)
    values = unknowns_of(model).pack(spring, np.zeros_like(spring), damper)
    # The model's springs are unloaded at the rotation 0, and no step moves the shifts of rests that are not estimated.
    locals_ = [Local(start.rotation, start.rate, end) for start, end in zip(begun, ends, strict=True)]
    stage = refine(model, held, FitStart(values, locals_), "noise", np.zeros_like(spring))
    solution = stage.solution
    loose = tuple(leg.joint_names[j] for j in loose_joints(model, solution))
    if np.any(clipped_rms(held, solution.predictions) > MISFIT * sample_scatter(held)):  # as in ``estimate``
        solution = soften(model, held, solution, stage.weights).solution
    return HeldAngleFit(np.exp(solution.values).reshape(2, -1), root_mean_square(held, solution.predictions), loose)


def _with_torque(recording: Recording, torque: Array) -> Recording:
    """A recording along which a constant torque (n,) N m on q acts."""
    assert not recording.driven
    return replace(recording, known_torque=(recording.time[[0, -1]], np.tile(torque, (2, 1))))


def free_angle_sentences(
    published: Array, fit: FitResult, held: HeldAngleFit, searched: Array, with_mistakes: Array
) -> list[str]:
    """Whether published rates (2, 3) differ from ``fit`` because of the free angles, and what else differs.

    ``searched``, ``with_mistakes`` : rates (2, 3) of the thesis' search, which takes the free angles from the ends too.
    """
    loose = [name for name in JOINTS if name in held.loose or family_of(fit, name) or ridge_sentence(fit, name)]
    own, found, wanted = (_compared(rates, loose) for rates in (found_rates(fit), held.rates, published))
    beside = [f" (estimated {mine:.3g}, published {theirs:.3g})" for mine, theirs in zip(own, wanted, strict=True)]
    opened = f" Where the releases leave k and b open ({listed(loose)}), b/k is compared." if loose else ""
    left = _degrees(held.rms), _degrees(np.array(list(fit.rms.values())))
    return [
        "With each release's free angles held where spring and weight balance in its final pose, as the thesis takes "
        f"them, and not estimated, least squares gives {_figures(found, loose, beside)}. The RMS residuals are "
        f"{left[0]} deg, with estimated free angles {left[1]} deg.{opened}",
        _verdict(np.log(own / wanted), np.log(found / wanted)),
        "What the free angles do not account for may come from the thesis' cost and weights, its bounds, its initial "
        "states, read from the first samples, its mistakes, and where its search ended. The same search (swarm, ours) "
        f"gives {_figures(_compared(searched, loose), loose)}, with the mistakes "
        f"{_figures(_compared(with_mistakes, loose), loose)}.",
    ]


def _compared(rates: Array, loose: Sequence[str]) -> Array:
    """(3,) of rates (2, 3): k N m/rad, or b/k s of the joints that tell no more."""
    return np.array([rates[1, j] / rates[0, j] if name in loose else rates[0, j] for j, name in enumerate(JOINTS)])


def _verdict(own: Array, held: Array) -> str:
    """What the free angles account for.

    ``own``, ``held`` : (3,) log differences from the published values, with free angles estimated and held.
    """
    gone, kept, none, farther = [], [], [], []
    for j, name in enumerate(JOINTS):
        share = 1.0 - abs(held[j] / own[j]) if own[j] else 0.0
        if abs(own[j]) < NEAR_DIFFERENCE:
            none.append(name)
        elif share >= LEAST_SHARE:
            gone.append(f"for {100 * share:.0f} % at {name}")
        else:
            kept.append(name)
        if abs(held[j]) - abs(own[j]) >= NEAR_DIFFERENCE:
            farther.append(f"{name} (then {percent(float(np.exp(held[j])))})")
    parts = [*gone, *([f"for nothing at {listed(kept)}"] if kept else [])]
    texts = [f"Of our difference from the published values the free angles account {listed(parts)}."] if parts else []
    if none:
        texts.append(f"There is none to account for at {listed(none)}: the same within {100 * NEAR_DIFFERENCE:.0f} %.")
    if farther:
        texts.append(f"Held, they move ours away from the published value at {listed(farther)}.")
    return " ".join(texts)


def _figures(values: Array, loose: Sequence[str], beside: Sequence[str] = ("", "", "")) -> str:
    """The compared figures (3,) in words, each with a text beside it."""
    kinds = [("b/k", "s") if name in loose else ("k", "N*m/rad") for name in JOINTS]
    named = zip(JOINTS, kinds, values, beside, strict=True)
    return listed([f"{name} {kind} {value:.3g} {unit}{text}" for name, (kind, unit), value, text in named])


def _degrees(rms: Array) -> str:
    return listed([f"{value:.2f}" for value in np.degrees(rms)])
