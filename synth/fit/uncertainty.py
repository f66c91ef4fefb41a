"""Uncertainty of the estimates, and what the trials leave open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array, finite_median
from synth.estimation.correlation import correlation_factors_by_step
from synth.estimation.intervals import NORMAL90, covariance_of
from synth.fit.diverged_fit import divergence_refused
from synth.fit.known import Known
from synth.fit.least_squares import Solution
from synth.fit.recordings import Recording
from synth.fit.rounding import encoder_counts
from synth.fit.trajectories import TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers
from synth.noise import MAD_TO_SD
from synth.remarks import Remark, at_joint
from synth.swing.driving_inputs import is_driven
from synth.swing.leg_model import Leg
from synth.swing.mechanics import outboard_inertia
from synth.units import significant

LOOSE_RATE = 0.12  # standard deviation of a log rate from which a rate counts as undetermined (+-20 % at 90 %)
# deviation of b/k over that of the rates, below which they are a ridge: 2.5 times as well known
SEPARABLE_QUOTIENT = 0.4
MASS_SCALE = "mass scale"  # kind of the remark that a common factor on masses and rates is not determined


def residuals(recording: Recording, prediction: Array) -> Array:
    """(m, n) rad, nan where no sample counts."""
    return np.where(recording.counts, prediction - recording.rotation, np.nan)


def root_mean_square(recordings: Sequence[Recording], predictions: Sequence[Array]) -> Array:
    """(n,) rad, the plain root mean square over all trials' counted angles; nan for a joint without any.

    Where a recording is thinned, these are means of samples: it is for comparisons of fits of the same recordings, and
    ``rms_as_recorded`` is stated.
    """
    return np.array([float(np.sqrt(np.mean(column**2))) if len(column) else np.nan
                     for column in _by_joint(recordings, predictions)])  # fmt: skip


def rms_as_recorded(recordings: Sequence[Recording], predictions: Sequence[Array]) -> Array:
    """(n,) rad, the plain root mean square over all samples as recorded; nan for a joint without any.

    Of a thinned recording over all samples of its counted groups, see ``GroupSpread``.
    """
    if all(recording.spread is None for recording in recordings):
        return root_mean_square(recordings, predictions)
    parts = [_squares(recording, prediction) for recording, prediction in zip(recordings, predictions, strict=True)]
    square, count = (np.sum(each, axis=0) for each in zip(*parts, strict=True))
    return np.asarray(np.sqrt(np.where(count > 0.0, square, np.nan) / np.maximum(count, 1.0)))


def _squares(recording: Recording, prediction: Array) -> tuple[Array, Array]:
    """(n,) rad^2, sum of a recording's squared residuals over its samples, and their number (n,)."""
    off = recording.rotation - prediction
    good = recording.counts & np.isfinite(off)
    if recording.spread is None:
        return np.sum(np.where(good, off, 0.0) ** 2, axis=0), good.sum(axis=0).astype(float)
    rate = np.zeros_like(off)
    for j in np.flatnonzero(good.sum(axis=0) > 2):
        rows = good[:, j]
        rate[rows, j] = np.gradient(prediction[rows, j], recording.time[rows], edge_order=2)
    squares = recording.spread.squares(np.where(good, off, 0.0), rate)
    return np.sum(np.where(good, squares, 0.0), axis=0), np.sum(np.where(good, recording.spread.sums[0], 0.0), axis=0)


def clipped_rms(recordings: Sequence[Recording], predictions: Sequence[Array]) -> Array:
    """(n,) rad, as ``root_mean_square`` with residuals truncated at six robust standard deviations.

    The fit estimates each joint's noise from it, so that a glitch does not dominate. It is not a measure of the fit.
    """
    columns = _by_joint(recordings, predictions)
    sizes = [np.abs(column) for column in columns]
    scales = [MAD_TO_SD * finite_median(size) + 1e-12 for size in sizes]
    found = [_clipped_size(size, scale) for size, scale in zip(sizes, scales, strict=True)]
    far = [j for j, (size, scale) in enumerate(zip(sizes, scales, strict=True)) if len(size) and size.max() > 6 * scale]
    if far:  # at rest on one count all residuals may be almost zero
        widths = encoder_counts(recordings)
        for j in far:
            found[j] = _clipped_size(sizes[j], max(scales[j], float(widths[j]) / np.sqrt(12.0)))
    return np.array(found)


def _by_joint(recordings: Sequence[Recording], predictions: Sequence[Array]) -> list[Array]:
    """Each joint's residuals (m,) rad at all counted samples of all trials."""
    stacked = np.concatenate(predictions) - np.concatenate([recording.rotation for recording in recordings])
    good = np.isfinite(stacked) & np.concatenate([recording.counts for recording in recordings])
    if good.all():
        return list(np.ascontiguousarray(stacked.T))
    return [column[mask] for column, mask in zip(stacked.T, good.T, strict=True)]


def _clipped_size(size: Array, scale: float) -> float:
    """RMS of residuals of these sizes (m,) rad truncated at six times ``scale`` rad."""
    if not len(size):
        return float("nan")
    held = np.minimum(size, 6 * scale)
    return float(np.sqrt(np.vdot(held, held) / len(held)))


def sample_scatter(recordings: Sequence[Recording]) -> Array:
    """(n,) rad, the samples' scatter about local polynomials, about the sensor's noise; at least the counts'.

    nan for a joint without a counted sample, such as one that is locked in all recordings.
    """
    squares = np.array([np.where(r.counts.any(axis=0), r.smoothed.noise**2, np.nan) for r in recordings])
    seen = np.isfinite(squares).sum(axis=0)
    found = np.sqrt(np.where(seen, np.nansum(squares, axis=0), np.nan) / np.maximum(seen, 1)) + 1e-9
    return np.asarray(np.fmax(found, np.where(np.isnan(found), np.nan, encoder_counts(recordings) / np.sqrt(12.0))))


def scatter_as_recorded(recordings: Sequence[Recording], scatter: Array) -> Array:
    """(n,) rad, the ``scatter`` (n,) of the angles about the motion, and of samples about thinned means."""
    if all(recording.spread is None for recording in recordings):
        return scatter
    inside = np.array([_inside_groups(recording) for recording in recordings])
    seen = np.array([recording.counts.any(axis=0) for recording in recordings])
    return np.asarray(np.sqrt(scatter**2 + np.where(seen, inside, 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)))


def _inside_groups(recording: Recording) -> Array:
    """(n,) rad^2, mean square of the samples about their groups' angles, along the smoothed motion."""
    if recording.spread is None:
        return np.zeros(recording.rotation.shape[1])
    smoothed = recording.smoothed
    rate = np.stack([np.interp(recording.time, smoothed.time, column) for column in smoothed.rate.T], axis=1)
    squares = np.where(recording.counts, recording.spread.squares(np.zeros_like(rate), rate), 0.0)
    samples = np.where(recording.counts, recording.spread.sums[0], 0.0)
    return np.asarray(squares.sum(axis=0) / np.maximum(samples.sum(axis=0), 1.0))


def all_residuals(recording: Recording, prediction: Array) -> Array:
    """(m, n) rad, of the samples that the cost leaves out too; nan where there is no good one."""
    return np.where(recording.known, prediction - recording.rotation, np.nan)


def correlation_times(recordings: Sequence[Recording], predictions: Sequence[Array]) -> Array:
    """(n_trial, n) factor >= 1 by which correlation reduces the information of each trial's samples.

    Alike for a joint's samples of one step in all trials, see ``correlation_factors_by_step``.
    """
    return correlation_of(recordings, [all_residuals(r, p) for r, p in zip(recordings, predictions, strict=True)])


def correlation_of(recordings: Sequence[Recording], left: Sequence[Array]) -> Array:
    """As ``correlation_times``, of ``all_residuals`` (m, n) of each trial.

    Each joint by its own clock: the rows of others are no gaps of it. The noise is that of all good samples, the
    information that of those that count: those of the cost ``transient`` alone are mostly of the beginning, where the
    fit follows the noise. With noise correlated by 0.9 the 90 % interval of a free angle held it in 55 % of 100 data
    sets by them, and in 78 % by all (in 85 % with the cost ``trajectory``).
    """
    factors = np.ones((len(recordings), left[0].shape[1]))
    for j in range(factors.shape[1]):
        own = [recording.moments[:, j] for recording in recordings]
        series = [each[rows, j : j + 1] for each, rows in zip(left, own, strict=True)]
        counts = None
        if any(recording.left_out is not None for recording in recordings):
            counts = [recording.counts[rows, j : j + 1] for recording, rows in zip(recordings, own, strict=True)]
        steps = [recording.steps[j] for recording in recordings]
        factors[:, j] = correlation_factors_by_step(series, steps, counts)[:, 0]
    return factors


@divergence_refused()
def covariance(model: TrajectoryModel, solution: Solution, *, with_prior: bool = True) -> Array:
    """Covariance (p, p) of the common unknowns; null directions get a very large variance instead of an error.

    ``with_prior`` : False leaves out the weak priors of typical limbs; what the user states of a rate is knowledge of
    this leg, and counts always.

    Raises
    ------
    UserError : the simulation diverges at the solution.
    """
    schur = solution.information.schur()
    if not with_prior:
        schur = schur - np.diag(model.unknowns.weak_precision)
    return covariance_of(schur)


def shift_variances(model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution) -> Array:
    """(n_trial, n) rad^2, variance of each trial's rest shift for given common unknowns; nan for locked joints."""
    shifts = []
    for recording, own in zip(recordings, solution.information.own, strict=True):
        first = 2 * len(recording.free)
        variance = np.full(recording.rotation.shape[1], np.nan)
        variance[model.shifted(recording)] = np.diag(np.linalg.inv(own))[first:]
        shifts.append(variance)
    return np.array(shifts)


def is_ridge(cov: Array, spring: int, damper: int) -> bool:
    """Whether the trials tell the quotient of two rates far better than the rates: a ridge, not two poorly known rates.

    ``cov`` (p, p) of the logarithms without the weak priors; ``spring`` and ``damper`` are places in it.
    """
    largest = float(np.sqrt(max(cov[spring, spring], cov[damper, damper])))
    return largest > LOOSE_RATE and _deviation_of_quotient(cov, spring, damper) < SEPARABLE_QUOTIENT * largest


def _deviation_of_quotient(cov: Array, first: int, other: int) -> float:
    """Standard deviation of the difference of two logarithms."""
    return float(np.sqrt(max(0.0, cov[first, first] + cov[other, other] - 2 * cov[first, other])))


def not_separable(unknowns: SpringsAndDampers, known: Known) -> list[Remark]:
    """Sentences on what the trials leave open, each with the measurement that would determine it.

    Whether something is open is asked of the trials and of what the user states; how far it is known is the reported
    90 % interval of everything, as in the table and the proposals.
    """
    sentences = []
    for j, joint in enumerate(unknowns.leg.joint_names):
        if j in unknowns.rates:
            sentences += [at_joint(joint, text) for text in _open_rates(unknowns, j, known)]
    for j in unknowns.rests:
        place, joint = unknowns.rest_at(j), unknowns.leg.joint_names[j]
        # +-2.5 deg at 90 %: a quarter of a bought spring's tolerance
        if known.deviation(place) > np.radians(1.5) and np.isfinite(known.ends[0][place]):
            text = f"the free angle is known only as {known.estimates[f'free_angle {joint}'].words} (90 %)."
            sentences.append(at_joint(joint, text))
    return sentences


def _open_rates(unknowns: SpringsAndDampers, j: int, known: Known) -> list[str]:
    """What the trials leave open of one joint's rates."""
    position, joint = unknowns.rate_at(j), unknowns.leg.joint_names[j]
    spring, damper = (known.estimates.get(f"{what} {joint}") for what in ("spring_rate", "damper_rate"))
    other = unknowns.damper_at(j) if j in unknowns.dampers else None
    if spring is not None and damper is not None and other is not None and is_ridge(known.trials, position, other):
        quotient = known.quotient(other, position)
        return [
            f"not separable: spring rate and damper rate. The trials give b/k = {significant(quotient.value, 3)} s "
            f"({quotient.words}), but k only as {spring.words} and b as {damper.words} (90 %). A static torque-angle "
            "point at this joint would separate them."
        ]
    texts, remedy = [], "More trials, or releases in which this joint moves more, would determine it better."
    for place, what, estimate in ((position, "spring rate", spring), (other, "damper rate", damper)):
        if place is None or estimate is None:
            continue
        if known.ends[0][place] == -np.inf:
            assert estimate.high is not None
            texts.append(_none_sentence(what, estimate.high))
        elif known.deviation(place) > LOOSE_RATE:
            mend = "A static torque-angle point at this joint would determine it." if other is None else remedy
            texts.append(f"these trials determine the {what} only as {estimate.words} (90 %). {mend}")
    return texts


def _none_sentence(what: str, most: float) -> str:
    """What the trials say of a rate that they do not tell from none; ``most`` the upper end of its interval, SI."""
    unit, more = ("N*m/rad", " Its free angle is unknown.") if what == "spring rate" else ("N*m*s/rad", "")
    return f"these trials do not tell the {what} from none: it is at most some {significant(most, 2)} {unit}.{more}"


def like_none(unknowns: SpringsAndDampers, place: int, values: Array) -> bool:
    """Whether a log rate lies below the prior's range: there a poorly determined one is where the prior stopped it."""
    mean, precision = (each[place] for each in unknowns.prior)
    return bool(values[place] < mean - NORMAL90 / np.sqrt(precision))


def mass_scale_sentence(leg: Leg, recordings: Sequence[Recording], *, weighed: bool = False) -> Remark | None:
    """Whether the trials determine a common factor on masses, spring and damper rates; a sentence if not.

    ``weighed``: a static point with a known torque or mass is given. A damper of known curve tells the scale too,
    where its joint moves: its torque does not grow with the masses.
    """
    curved = [j for j, joint in enumerate(leg.joints) if joint.damper is not None and joint.damper.curve is not None]
    scale_known = weighed or any(
        is_driven(r.known_torque, r.signals) or not set(curved).isdisjoint(r.free) for r in recordings
    )
    scale_known = scale_known or len({r.conditions.tip_mass for r in recordings}) > 1
    if scale_known:
        return None
    last = leg.joints[-1]
    mass = 1e3 * float(outboard_inertia(leg)[-1]) / last.link.length**2
    mass, unit = (mass, "g") if mass < 1e3 else (1e-3 * mass, "kg")
    text = (
        "not separable: mass scale, from free swings alone. Spring and damper rates are proportional to the link "
        "masses in the leg file. A trial with a known mass at the tip determines the scale: with "
        f"`tip_mass: {significant(mass, 2)} {unit}` the inertia about the {last.name} doubles, and the scale is known "
        "to twice the interval of that joint's spring rate."
    )
    return Remark(text, kind=MASS_SCALE)
