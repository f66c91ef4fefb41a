"""Noise and counts of the angle channels, from the samples only.

Differences of a high order see the highest frequencies, which a low-pass filter takes away: of filtered readings they
show the rounding of the file, often a hundredth of what the filter let through. Differences of every D-th sample see
lower ones. While they lie above the filter's cut-off they grow steeply with D; between the cut-off and the motion's
frequencies they stay at the noise that the filter let through; beyond, the motion's own differences take over, steeply
again. So the noise of filtered readings is read where they grow least.

A filter that leaves a part of the noise at all frequencies, as a mean of some readings does, has no such plateau, and
where the motion is fast for the sampling rate none lies between. It shows in the spectrum: see ``noise_spectrum``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask
from synth.fit.noise_spectrum import FilteredNoise, filter_with_ratio, filtered_noise
from synth.fit.recordings import Recording
from synth.motion.counts import LEAST_GAP, on_counts, width_of
from synth.motion.low_pass import LowPass
from synth.noise import robust_deviation, unit_differences
from synth.remarks import decisive
from synth.units import significant

DIFFERENCE_ORDER = 6  # order of differences that isolate noise: the sixth difference of a smooth motion is almost zero
STRIDE_ORDER = 10  # of those of every D-th sample: the motion takes over later
SAME_SENSOR_SHARE = 0.2  # joints whose noise differs by a smaller share are assumed to have the same sensor
LEAST_DIFFERENCES = 20  # differences: a median of fewer is no noise
# Scatter about a smooth motion over the noise by differences: above the first readings were filtered, above the
# second they may have been
FILTERED_RATIO, DOUBTFUL_RATIO = 3.0, 1.5
STRIDES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)  # D: steps of at most a factor 2, which a plateau of an octave contains
INDEPENDENT_EXPONENT = 0.5  # exponent of growth with D of independent samples, as few as a trial has
FILTERED_GROWTH = 1.5  # times that exponent, growth at smaller D if a filter is the reason
NOISE_TO_MOTION = 3e-3  # of the motion, below which differences of every D-th sample are not yet the motion's own
# Of the motion, below which the step of the readings is a file's rounding, not an encoder's count.
FINE_STEP_TO_MOTION = 1e-4
CONTRADICTED = 3.0  # times the shown noise, or a third of it: the readings tell it within some per cent
LEAST_NOISE = 1e-9  # rad: so that readings of a simulation have some noise
ROUNDING_RATIO = 2.0  # times the noise of rounding, below which differences show the rounding


@dataclass(frozen=True)
class AngleSensor:
    """``noise`` (n,) rad RMS of a reading about the true angle; ``step`` (n,) rad of one count, 0 if not visible.

    ``scatter`` (n,) : readings about a smooth motion, or behind the filter that they show, over readings from one to
    the next; from ``FILTERED_RATIO`` on they were filtered. ``known`` : joints whose noise is stated, not read.
    ``of_mean`` (n,) : noise of a used angle over that of a reading, below 1 where dense readings are averaged.
    ``filters`` (n,) : what the noise went through, None where it seems independent from one reading to the next; of
    the joints ``by_spectrum`` the spectrum shows it.
    ``rounding_only`` : joints that show no noise but the rounding of the file's last digit. ``doubts`` : sentences on
    stated noises that the readings contradict.
    """

    noise: Array
    step: Array
    scatter: Array
    known: tuple[int, ...] = ()
    of_mean: Array | None = None
    filters: tuple[LowPass | None, ...] = ()
    by_spectrum: tuple[int, ...] = ()
    rounding_only: tuple[int, ...] = ()
    doubts: tuple[str, ...] = ()

    def stated(self, joints: Sequence[str], noise: Mapping[str, float] | None) -> AngleSensor:
        """With the noise (rad) of a reading that a project states of some joints, in place of what they show."""
        share = np.ones(len(joints)) if self.of_mean is None else self.of_mean
        known = {joints.index(joint): value * share[joints.index(joint)] for joint, value in (noise or {}).items()}
        found = self.noise.copy()
        found[list(known)] = [*known.values()]
        doubts = [
            _doubt(joint, value, float(self.noise[j] / share[j]))
            for joint, value in (noise or {}).items()
            if (j := joints.index(joint)) not in self.rounding_only
        ]
        return replace(self, noise=found, known=tuple(known), doubts=tuple(each for each in doubts if each is not None))


def _doubt(joint: str, stated: float, shown: float) -> str | None:
    """A sentence on a stated noise (rad) that is ``CONTRADICTED`` times the one that the readings show, or less so."""
    if shown <= 0.0 or 1.0 / CONTRADICTED < stated / shown < CONTRADICTED:
        return None
    what, seen = (f"{significant(float(np.degrees(each)), 2)} deg" for each in (stated, shown))
    text = f"{joint}: a noise of {what} is stated, and the readings scatter by {seen} from one to the next"
    remedy = (
        "The stated one is used, in odds and remainder: check its digits and its unit, or leave it out. State an "
        "error that lasts from reading to reading as accuracy:"
    )
    return decisive(text, remedy)


def estimate_sensor(recordings: Sequence[Recording]) -> AngleSensor:
    """Noise and counts of each joint's channel, from the samples only.

    Noise by sixth differences (Tukey, *Exploratory Data Analysis* 1977; von Neumann et al., Ann. Math. Stat. 12 (1941)
    153, for the first): white noise of deviation s gives them the deviation ``s sqrt(sum binom(6, k)^2)``; of uneven
    samples by divided differences. Those beyond three robust deviations are left out. Joints that differ by less than
    ``SAME_SENSOR_SHARE`` are pooled. A coarse count makes steps that no difference shows while the joint rests; its
    ``step/sqrt(12)`` is then used as noise (Widrow & Kollar, *Quantization Noise*, 2008, ch. 1). Filtered readings as
    told above.
    """
    n = recordings[0].rotation.shape[1]
    squares: list[list[float]] = [[] for _ in range(n)]
    gaps: list[list[Array]] = [[] for _ in range(n)]
    for recording in recordings:
        for j in recording.free:
            time, value, good = recording.channel(j)
            found = _noise_variance(time, value, good, DIFFERENCE_ORDER)
            if not np.isfinite(found):
                continue
            squares[j].append(found)
            gaps[j].append(np.diff(np.unique(np.round(value[good], 12))))
    # The median over trials, so that a trial with impacts or at rest does not dominate.
    white = np.array([np.sqrt(np.median(s)) if s else np.nan for s in squares])
    known = white[np.isfinite(white)]
    if not len(known):  # too few samples for differences: use the scatter about the smoothed motion
        known = np.concatenate([recording.smoothed.noise[recording.free] for recording in recordings])
    white = np.where(np.isfinite(white), white, np.median(known))
    step = np.array([width_of(np.concatenate(each), LEAST_GAP) if each else 0.0 for each in gaps])
    step = np.where((step > 0.0) & _on_grid(recordings, step), step, 0.0)
    noise = np.maximum(white, step / np.sqrt(12.0)) + LEAST_NOISE
    exact = _only_rounding(recordings, noise, step)
    scatter = np.array([_scatter_ratio(recordings, j, float(noise[j])) for j in range(n)])
    behind = [_behind_filter(recordings, j, float(noise[j]), float(step[j])) for j in range(n)]
    shown = tuple(j for j, seen in enumerate(behind) if seen)
    neighbours = noise
    through = np.array([0.0 if seen is None else seen.noise for seen in behind])
    noise, assumed = _noise_of_filtered(recordings, noise, step, scatter, exact, through)
    scatter = np.maximum(scatter, noise / neighbours)
    filters = tuple(
        seen.filter if seen else filter_with_ratio(white_part, DIFFERENCE_ORDER)
        for seen, white_part in zip(behind, np.where(assumed, 1.0, neighbours / noise).tolist(), strict=True)
    )
    usual = float(np.median(noise))
    alike = np.abs(np.log(noise / usual)) < SAME_SENSOR_SHARE
    if np.any(alike):
        noise[alike] = np.sqrt(np.mean(noise[alike] ** 2))
    of_mean = np.array([_noise_of_mean(recordings, j) for j in range(n)])
    still = np.flatnonzero(exact & (noise <= _most_rounding(step)))
    return AngleSensor(
        noise, step, scatter, of_mean=of_mean, filters=filters, by_spectrum=shown, rounding_only=tuple(still.tolist())
    )


def _behind_filter(recordings: Sequence[Recording], joint: int, noise: float, step: float) -> FilteredNoise | None:
    """The filter of a joint's readings by their spectrum; None for means of dense readings and for coarse counts.

    ``noise`` and ``step`` (rad) of neighbouring readings. Counts as large as the noise depend on the motion between
    them, and have no spectrum of their own.
    """
    if step >= FINE_STEP_TO_MOTION * _motion_rms(recordings, joint) and step > noise / ROUNDING_RATIO:
        return None
    found = filtered_noise(recordings, joint, step)
    return found if found and found.noise > max(noise, ROUNDING_RATIO * step / np.sqrt(12.0)) else None


def _noise_of_mean(recordings: Sequence[Recording], joint: int) -> float:
    """Noise of an angle over that of a reading, as of the usual trial; see ``motion.thinning``."""
    found = [
        1.0 / recording.averaged[joint] for recording in recordings if recording.averaged and joint in recording.free
    ]
    return float(np.sqrt(np.median(found))) if found else 1.0


def _scatter_ratio(recordings: Sequence[Recording], joint: int, noise: float) -> float:
    """Scatter about a smooth motion over this noise (rad); 0 for a joint that is never free."""
    ratio = [r.smoothed.noise[joint] / noise for r in recordings if joint in r.free]
    return float(np.median(ratio)) if ratio else 0.0


def _noise_variance(time: Array, value: Array, good: Mask, order: int) -> float:
    """rad^2, of the white noise of readings (m,), by their differences; nan for too few."""
    if len(value) < order + LEAST_DIFFERENCES:
        return np.nan
    difference = unit_differences(time, value, order)[np.lib.stride_tricks.sliding_window_view(good, order + 1).all(1)]
    if len(difference) < LEAST_DIFFERENCES:
        return np.nan
    robust = robust_deviation(difference) + 1e-12
    kept = difference[np.abs(difference) < 3.0 * robust]
    return float(np.mean(kept**2)) / 0.9733  # variance of a normal truncated at 3


def _most_rounding(step: Array) -> Array:
    """(n,) rad: the largest noise that the rounding to steps (n,) rad may be."""
    return np.asarray(ROUNDING_RATIO * step / np.sqrt(12.0) + LEAST_NOISE)


def _only_rounding(recordings: Sequence[Recording], noise: Array, step: Array) -> Mask:
    """(n,) True where neighbouring readings show no noise but a file's rounding."""
    fine = [width < FINE_STEP_TO_MOTION * _motion_rms(recordings, j) for j, width in enumerate(step)]
    return np.asarray((noise <= _most_rounding(step)) & np.array(fine))


def _noise_of_filtered(
    recordings: Sequence[Recording], noise: Array, step: Array, scatter: Array, exact: Mask, by_spectrum: Array
) -> tuple[Array, Mask]:
    """(n,) rad: the noise, for filtered channels what the filter let through; (n,) True where it tells no filter.

    Where neither a plateau nor the spectrum shows that of filtered readings, because the motion goes on up to the
    filter's edge, it is that of the other channels: the differences tell only what is left above the edge, of one joint
    a thirtieth of what they tell of another with the same sensor. Without any other it is the scatter about a smooth
    motion, of several joints its geometric mean. No filter follows from it: a simulation may be as smooth.
    ``exact`` (n,) : from one reading to the next there is only rounding; a smooth motion may follow filtered noise,
    without any scatter. ``by_spectrum`` (n,) rad, 0 where it shows none.
    """
    let = by_spectrum.copy()
    for j in np.flatnonzero((scatter >= DOUBTFUL_RATIO) | exact).tolist():
        let[j] = max(let[j], _noise_through_filter(recordings, j, float(step[j])))
    unseen = (scatter >= FILTERED_RATIO) & (let == 0.0)
    if unseen.any():
        about = float(np.exp(np.mean(np.log((scatter * noise)[unseen]))))
        let[unseen] = np.median(let[let > 0.0]) if (let > 0.0).any() else about
    return np.maximum(noise, let), unseen & (noise > _most_rounding(step))


def _noise_through_filter(recordings: Sequence[Recording], joint: int, step: float) -> float:
    """Noise (rad) that a filter let through, where the differences of every D-th sample grow least with D; 0: not seen.

    Only where they grow faster before. Of independent samples the noise of neighbouring ones.
    """
    channels = [r.channel(joint) for r in recordings if joint in r.free]
    deviations = []
    for stride in STRIDES:
        found = [
            _noise_variance(time[k::stride], value[k::stride], good[k::stride], STRIDE_ORDER)
            for time, value, good in channels
            for k in range(0, stride, max(1, stride // 4))
        ]
        known = [each for each in found if np.isfinite(each)]
        deviations.append(float(np.sqrt(np.median(known))) if known else np.nan)
    seen = np.where(np.array(deviations) > 0.0, deviations, np.nan)  # zero: coarse counts of a joint at rest
    growth = np.diff(np.log(seen)) / np.diff(np.log(STRIDES))
    moved = _motion_rms(recordings, joint)
    tells = (
        (seen[:-1] > ROUNDING_RATIO * step / np.sqrt(12.0)) & (seen[1:] < NOISE_TO_MOTION * moved) & np.isfinite(growth)
    )
    if tells[0] and growth[0] < INDEPENDENT_EXPONENT:
        return float(seen[0])
    for k in np.flatnonzero(tells).tolist():
        later = growth[k + 1] if k + 1 < len(growth) and tells[k + 1] else np.inf
        steep = np.nanmax(growth[:k], initial=0.0) >= FILTERED_GROWTH * max(growth[k], INDEPENDENT_EXPONENT)
        if steep and growth[k] <= later:
            return float(np.sqrt(seen[k] * seen[k + 1]))
    return 0.0


def _motion_rms(recordings: Sequence[Recording], joint: int) -> float:
    """RMS (rad) of a joint's motion about its mean in the trial in which it moves most; 0 if it is never free."""
    free = [r for r in recordings if joint in r.free]
    return max((float(np.std(r.rotation[r.counts[:, joint], joint])) for r in free), default=0.0)


def _on_grid(recordings: Sequence[Recording], step: Array) -> Mask:
    """(n,) True where nearly all readings differ from one another by multiples of the step."""
    found = np.zeros(len(step), dtype=bool)
    for j, width in enumerate(step):
        if width <= 0.0:
            continue
        found[j] = on_counts(np.concatenate([r.rotation[r.counts[:, j], j] for r in recordings if j in r.free]), width)
    return found
