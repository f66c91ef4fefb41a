"""Shapes of commands: what each joint follows, between -1 and 1 of its range of angles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from synth.arrays import Array

# Samples per second of a command, each of which is held: as fast as a controller usually reads them.
COMMAND_RATE = 200.0
CHIRP_BAND = (0.2, 2.5)  # Hz: the bandwidth of a position servo with a limb
STAIRCASE_LEVELS = 5  # angles of a staircase: with and against gravity, and between
SINE_SEEDS = 3  # sums of sines with different phases, of which the best is used

# Times (m,) s and the time (s) from one end to the other at full speed -> -1..1.
Shape = Callable[[Array, float], Array]


def _length(time: Array) -> float:
    """S, of a command with samples at ``time``."""
    return float(time[-1]) + 1.0 / COMMAND_RATE


def limit_rate(wanted: Array, most: float) -> Array:
    """(m,) a signal that follows ``wanted`` with at most ``most`` change per second, between -1 and 1."""
    made, step = np.clip(wanted, -1.0, 1.0), most / COMMAND_RATE
    for k in range(1, len(made)):
        made[k] = made[k - 1] + np.clip(made[k] - made[k - 1], -step, step)
    return np.asarray(made)


def _triangle(time: Array, crossing: float) -> Array:
    """A triangle from the middle up, down and up between -1 and 1, ``crossing`` s from end to end."""
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(np.pi * time / crossing)))


def _staircase(time: Array, crossing: float) -> Array:
    """Up and down over ``STAIRCASE_LEVELS`` angles, with a pause at each and full speed between."""
    places = np.r_[np.linspace(0.0, 1.0, STAIRCASE_LEVELS), np.linspace(1.0, -1.0, 2 * STAIRCASE_LEVELS - 1)[1:], 0.0]
    hold = _length(time) / len(places)
    starts = hold * np.arange(len(places))
    # A pause of at least a tenth of each level's time.
    knots = np.column_stack([starts, starts + hold - np.minimum(0.9 * hold, 0.5 * crossing / STAIRCASE_LEVELS)])
    return np.asarray(np.interp(time, knots.ravel(), np.repeat(places, 2)))


def _small_steps(time: Array, crossing: float) -> Array:
    """Steps of a tenth and less about three angles, sensitive to dead band, backlash and presliding."""
    index = (time / 0.25).astype(int)
    place = np.array([0.0, 0.6, -0.6])[np.minimum((3.0 * time / _length(time)).astype(int), 2)]
    size = np.array([0.0, 0.05, 0.0, -0.05, 0.0, 0.1, 0.0, -0.1])[index % 8]
    return np.asarray(place + size)


def _hard_steps(time: Array, crossing: float) -> Array:
    """Steps from one end to the other at full speed, with a pause of half a second at each."""
    period = crossing + 0.5
    inside = np.mod(time, 2.0 * period)
    return np.interp(inside, [0.0, crossing, period, period + crossing, 2.0 * period], [-1.0, 1.0, 1.0, -1.0, -1.0])


def chirp(time: Array, crossing: float) -> Array:
    """A sine with rising frequency over ``CHIRP_BAND``, with smaller amplitude where it would be too fast."""
    first, last = CHIRP_BAND
    length = _length(time)
    rate = (last / first) ** (time / length) * first
    phase = 2.0 * np.pi * first * length / np.log(last / first) * ((last / first) ** (time / length) - 1.0)
    return np.asarray(np.sin(phase) * np.minimum(1.0, 2.0 / (crossing * 2.0 * np.pi * rate)))


def _sines(seed: int) -> Shape:
    """A sum of sines over ``CHIRP_BAND`` with phases of this seed, with the largest possible amplitude."""

    def shape(time: Array, crossing: float) -> Array:
        generator = np.random.default_rng(seed)
        rates = np.geomspace(*CHIRP_BAND, 8)
        phases = generator.uniform(0.0, 2.0 * np.pi, len(rates))
        total = np.sum(np.sin(2.0 * np.pi * rates * time[:, None] + phases) / rates**0.5, axis=1)
        total /= np.abs(total).max()
        fastest = np.abs(np.diff(total)).max() * COMMAND_RATE
        return np.asarray(total * min(1.0, 2.0 / crossing / fastest))

    return shape


def _one_after_other(first: Shape, second: Shape) -> Shape:
    """One in the first half, the other from its own start in the second."""

    def shape(time: Array, crossing: float) -> Array:
        half = 0.5 * _length(time)
        start, end = first(time, crossing), second(np.maximum(time - half, 0.0), crossing)
        blend = np.clip((time - half) / max(crossing, 0.1), 0.0, 1.0)  # s: no jump
        return np.asarray((1.0 - blend) * start + blend * end)

    return shape


def shapes(length: float) -> dict[str, Shape]:
    """Words -> shape of a command of ``length`` s, the chirp first."""

    def creep(time: Array, crossing: float) -> Array:
        return _triangle(time, max(crossing, 0.5 * length))

    def haste(time: Array, crossing: float) -> Array:
        return _triangle(time, crossing)

    whole: dict[str, Shape] = {
        "a chirp": chirp,
        "a slow ramp up and down": creep,
        "ramps at full speed": haste,
        "a staircase with pauses": _staircase,
        "small steps about three angles": _small_steps,
        "hard steps from end to end": _hard_steps,
    }
    whole |= {f"a sum of sines ({seed + 1})": _sines(seed) for seed in range(SINE_SEEDS)}
    whole |= {
        "a slow ramp, then hard steps": _one_after_other(creep, _hard_steps),
        "hard steps, then small ones": _one_after_other(_hard_steps, _small_steps),
        "a sum of sines, then a slow ramp": _one_after_other(_sines(0), creep),
    }
    return whole
