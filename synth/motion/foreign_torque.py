"""The beginning of free motion: an external torque (hand, string, muscle) is one that no spring or damper produces.

In free motion joint j's torque, which follows from the recorded motion and the links by inverse dynamics, is
``constant - k q - b dq/dt``, with or without ``- c sign(dq/dt)`` for dry friction. The constants are estimated from
the end of the recording backwards, and each earlier sample is predicted from the later ones (recursive residuals
with time reversed: Brown, Durbin & Evans, *J. R. Stat. Soc. B* 37 (1975) 149). An external torque is reported only if
neither law predicts the torque: without friction every leg with friction would look driven, with it alone a noisy swing
would. A prediction counts if the motion after it is well above the noise of its angles and rates, because noise in a
regressor biases its coefficient to zero and makes a free sample look driven (Fuller, *Measurement Error Models*,
1987, section 1.1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.motion.smoothing import Smoothed, polynomial_noise, savitzky_golay
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, momentum_and_force

DEVIATIONS = 3.0  # of a prediction's own uncertainty, least deviation of an external torque
FOREIGN_SHARE = 0.15  # of the joint's torque range, least deviation too: few real springs are linear to less
UNBROKEN_SHARE = 0.7  # of the samples since the start must be external and of one sign; the rest may be noise
LEAST_DURATION = 0.015  # s, longer than noise lasts
LONGEST_DURATION = 0.4  # s after the start, range of the search
SIGN_SMOOTHING = 4.0  # of the rates' noise, smoothing of the sign in the dry friction's column
ATTENUATION = 0.1  # share of a regressor that may be noise
SAMPLES = 4_000  # after the start, used for the test: hours of rest after a release add nothing


@dataclass(frozen=True)
class Drive:
    """An external torque at the start of a recording.

    ``until`` : s, the last sample at which it is detected, on the recording's clock.
    ``joint`` : index of the joint on which it is detected last.
    ``share`` : its largest size, as a share of the joint's torque range.
    """

    until: float
    joint: int
    share: float


def drive_after(leg: Leg, smoothed: Smoothed, points: int, free: list[int], tip_mass: float = 0.0) -> Drive | None:
    """The external torque from the start of a smoothed recording, None if none is detected.

    Parameters
    ----------
    smoothed : from the release, without samples before it, because the kink would look like a torque.
    points : of the smoothing polynomials; the first half of them cannot be tested.
    free : joints that could move.
    """
    momentum, force = momentum_and_force(coefficients(leg, tip_mass), smoothed.angle, smoothed.rate, leg.tilt)
    step = float(smoothed.time[1] - smoothed.time[0])
    torque = savitzky_golay(momentum, points, 3, step)[1] - force
    last: Drive | None = None
    for joint in free:
        laws = [_joint_drive(smoothed, torque[:, joint], joint, points, dry=dry) for dry in (False, True)]
        seen = [found for found in laws if found is not None]
        if len(seen) == len(laws):
            earliest = min(seen, key=lambda drive: drive.until)
            if last is None or earliest.until > last.until:
                last = earliest
    return last


@dataclass(frozen=True)
class _Predictions:
    """Each sample's torque against its prediction from later samples.

    ``miss`` (m,) N m; ``deviation`` (m,) N m, infinite if the later motion does not determine it; ``span`` (m,) N m,
    the joint's torque range; ``solution`` (m, 3 or 4) for the columns of ``regressors`` (n, 3 or 4); ``known`` (n,)
    where no gap is near.
    """

    miss: Array
    deviation: Array
    span: Array
    solution: Array
    regressors: Array
    known: Mask


def _slopes_known(smoothed: Smoothed, points: int) -> Mask:
    """(n,) where no gap is within reach of the torque, the slope of a polynomial of so many ``points``."""
    half = points // 2
    near = np.lib.stride_tricks.sliding_window_view(np.pad(smoothed.gap, half, mode="edge"), 2 * half + 1)
    return np.asarray(~near.any(axis=1))


def _joint_drive(smoothed: Smoothed, torque: Array, joint: int, points: int, *, dry: bool) -> Drive | None:
    """The latest sample up to which one joint is continuously driven since the start, by the law with ``dry``."""
    predicted = _predict(smoothed, torque[:SAMPLES], joint, points, dry=dry)
    if predicted is None:
        return None
    step = float(smoothed.time[1] - smoothed.time[0])
    count = len(predicted.miss)
    first = points // 2
    size = np.abs(predicted.miss)
    foreign = (size > DEVIATIONS * predicted.deviation) & (size > FOREIGN_SHARE * predicted.span)
    foreign[:first] = False
    foreign[round(LONGEST_DURATION / step) + 1 :] = False
    for end in _run_ends(foreign, max(2, round(LEAST_DURATION / step))):
        miss = torque[first : end + 1] - predicted.regressors[first : end + 1] @ predicted.solution[end]
        miss = miss[predicted.known[first : end + 1]]
        beyond = np.abs(miss) > FOREIGN_SHARE * predicted.span[end]
        sign = float(np.sign(miss[beyond]).mean())
        if beyond.mean() >= UNBROKEN_SHARE and abs(sign) >= UNBROKEN_SHARE:
            share = float(np.abs(miss).max() / predicted.span[end])
            return Drive(float(smoothed.time[min(end + 1, count)]), joint, share)
    return None


def _run_ends(flag: NDArray[np.bool_], length: int) -> NDArray[np.intp]:
    """Indices at which a run of at least ``length`` true values stands, the latest first."""
    if len(flag) < length:
        return np.zeros(0, dtype=np.intp)
    whole = np.lib.stride_tricks.sliding_window_view(flag, length).all(axis=1)
    return (np.flatnonzero(whole) + length - 1)[::-1]


def _predict(smoothed: Smoothed, torque: Array, joint: int, points: int, *, dry: bool) -> _Predictions | None:
    """All predictions at once, from reverse cumulative sums; None if the recording is too short."""
    n = len(torque)
    angle, rate = smoothed.angle[:n, joint], smoothed.rate[:n, joint]
    step = float(smoothed.time[1] - smoothed.time[0])
    angle_noise, rate_noise = (smoothed.noise[joint] * each for each in polynomial_noise(points, 3, step))
    columns = [angle[-1] - angle, -rate, np.ones(n)]
    columns += [-rate / np.hypot(rate, SIGN_SMOOTHING * rate_noise + 1e-12)] if dry else []
    regressors = np.stack(columns, axis=1)
    scale = np.abs(regressors).max(axis=0) + 1e-12
    # A prediction uses samples whose polynomials do not overlap the predicted one's far side.
    lag = points // 2
    count = n - lag - 3 * points
    if count <= 0:
        return None
    known = _slopes_known(smoothed, points)[:n]
    x = regressors / scale * known[:, None]
    counted = torque * known
    later = slice(lag, lag + count)
    normal = _reverse_sum(x[:, :, None] * x[:, None, :])[later] + 1e-9 * np.eye(len(columns))
    side = _reverse_sum(x * counted[:, None])[later]
    left = np.maximum(_reverse_sum(known.astype(float))[later], 1.0)
    solution = np.linalg.solve(normal, side[..., None])[..., 0]
    misfit = np.maximum(_reverse_sum(counted**2)[later] - np.einsum("ti,ti->t", solution, side), 0.0)
    leverage = np.einsum("ti,tij,tj->t", x[:count], np.linalg.inv(normal), x[:count])
    deviation = np.sqrt(misfit / left * (1.0 + leverage))
    noise = np.array([angle_noise, rate_noise, 0.0, 0.0][: len(columns)]) / scale
    of_noise = left[:, None, None] * np.diag(noise**2)
    share = np.abs(np.linalg.eigvals(np.linalg.solve(normal, of_noise))).max(axis=-1)
    deviation[(share > ATTENUATION) | ~known[:count]] = np.inf
    some = torque[points // 2 :][known[points // 2 :]]
    if not len(some):
        return None
    # The range of all torques, which no later one exceeds.
    span = np.full(count, np.ptp(some))
    miss = torque[:count] - np.einsum("ti,ti->t", x[:count], solution)
    return _Predictions(miss, deviation, span, solution / scale, regressors, known)


def _reverse_sum(value: Array) -> Array:
    """Sums from each index to the end."""
    return np.cumsum(value[::-1], axis=0)[::-1]
