"""Command trajectories for a servo-driven leg's next trial, within the limits of its earlier trials.

The best command depends on the causes to be separated: friction that falls with speed needs slow and fast motion, a
current limit a hard step, a dead band small steps about one angle, a share of the load the same motion with and against
gravity. The menu has one command for each of these, combinations, and a chirp for comparison;
``next_experiment`` weighs them by the predictions of the remaining rivals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo, ServoSignals
from synth.fit.recordings import Recording
from synth.motion.smoothing import Smoothed
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg

LENGTH, RATE = 6.0, 100.0  # s and samples per second: as long as the logs of the servo benches examined
CHIRP = (0.2, 2.5)  # Hz: the bandwidth of a position servo with a limb
LEVELS = 5  # angles of a staircase: with and against gravity, and between
SEEDS = 3  # sums of sines with different phases, of which the best is used


@dataclass(frozen=True)
class CommandLimits:
    """Limits of a command per joint: ``low``, ``high`` (n,) rad on q, ``speed`` (n,) rad/s."""

    low: Array
    high: Array
    speed: Array

    @classmethod
    def of(cls, leg: Leg, trials: Sequence[AngleTrial]) -> CommandLimits:
        """As wide and as fast as the commands so far, within the joints' ranges."""
        recorded = [trial.recording.signals for trial in trials]
        known = [signals for signals in recorded if signals is not None]
        low = np.min([signals.command.min(axis=0) for signals in known], axis=0)
        high = np.max([signals.command.max(axis=0) for signals in known], axis=0)
        for j, joint in enumerate(leg.joints):
            if joint.ends is not None:
                low[j], high[j] = max(low[j], joint.ends[0]), min(high[j], joint.ends[1])
        speed = np.max([_fastest(signals) for signals in known], axis=0)
        return cls(low, high, np.maximum(speed, (high - low) / LENGTH))


def _fastest(signals: ServoSignals) -> Array:
    """(n,) rad/s, the largest rate of change of a command apart from jumps."""
    rate = np.abs(np.diff(signals.command, axis=0)) / np.diff(signals.time)[:, None]
    return np.asarray(np.percentile(rate, 98, axis=0))  # not a single outlier


def has_servo(leg: Leg, trials: Sequence[AngleTrial]) -> bool:
    """Whether a joint of the leg follows commands, and some trial records them."""
    driven = any(isinstance(joint.drive, Servo) and joint.drive.gain > 0.0 for joint in leg.joints)
    return driven and any(trial.recording.signals is not None for trial in trials)


def command_menu(leg: Leg, bench: Workbench, trials: Sequence[AngleTrial]) -> list[MenuItem[AngleTrial]]:
    """One trial per command; all driven joints follow it together, each within its own limits."""
    limits, time = CommandLimits.of(leg, trials), np.arange(0.0, LENGTH, 1.0 / RATE)
    made = []
    for what, shape in _shapes().items():
        command = np.stack([_within(shape, time, limits, j) for j in range(len(leg.joints))], axis=1)
        held = [j for j, joint in enumerate(leg.joints) if not isinstance(joint.drive, Servo)]
        command[:, held] = 0.0
        measured = dict(zip(leg.joint_names, leg.to_measured(command[:1])[0].tolist(), strict=True))
        driven = {name: leg.to_measured(command)[:, j] for j, name in enumerate(leg.joint_names) if j not in held}
        trial = _imagined(leg, bench.noise, time, command)
        made.append(MenuItem(what, {"file": "trials/next.csv"}, trial, measured, command=(time, driven)))
    return made


# Times (m,) s and the time (s) from one end to the other at full speed -> -1..1.
Shape = Callable[[Array, float], Array]


def _within(shape: Shape, time: Array, limits: CommandLimits, joint: int) -> Array:
    """(m,) rad: a shape between a joint's limits, at its speed."""
    low, high = limits.low[joint], limits.high[joint]
    crossing = max(high - low, 1e-9) / max(limits.speed[joint], 1e-9)
    return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * _no_faster(shape(time, crossing), 2.0 / crossing))


def _no_faster(wanted: Array, most: float) -> Array:
    """(m,) a signal that follows ``wanted`` with at most ``most`` change per second, between -1 and 1."""
    made, step = np.clip(wanted, -1.0, 1.0), most / RATE
    for k in range(1, len(made)):
        made[k] = made[k - 1] + np.clip(made[k] - made[k - 1], -step, step)
    return np.asarray(made)


def _triangle(time: Array, crossing: float) -> Array:
    """From the middle up, down and up between -1 and 1, ``crossing`` s from end to end."""
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(np.pi * time / crossing)))


def _staircase(time: Array, crossing: float) -> Array:
    """Up and down over ``LEVELS`` angles, with a pause at each and full speed between."""
    places = np.r_[np.linspace(0.0, 1.0, LEVELS), np.linspace(1.0, -1.0, 2 * LEVELS - 1)[1:], 0.0]
    hold = LENGTH / len(places)
    starts = hold * np.arange(len(places))
    # A pause of at least a tenth of each level's time.
    knots = np.column_stack([starts, starts + hold - np.minimum(0.9 * hold, 0.5 * crossing / LEVELS)])
    return np.asarray(np.interp(time, knots.ravel(), np.repeat(places, 2)))


def _small_steps(time: Array, crossing: float) -> Array:
    """Steps of a tenth and less about three angles, sensitive to dead band, backlash and presliding."""
    index = (time / 0.25).astype(int)
    place = np.array([0.0, 0.6, -0.6])[np.minimum((time / (LENGTH / 3.0)).astype(int), 2)]
    size = np.array([0.0, 0.05, 0.0, -0.05, 0.0, 0.1, 0.0, -0.1])[index % 8]
    return np.asarray(place + size)


def _hard_steps(time: Array, crossing: float) -> Array:
    """From one end to the other at full speed, with a pause of half a second at each."""
    period = crossing + 0.5
    inside = np.mod(time, 2.0 * period)
    return np.interp(inside, [0.0, crossing, period, period + crossing, 2.0 * period], [-1.0, 1.0, 1.0, -1.0, -1.0])


def _chirp(time: Array, crossing: float) -> Array:
    """A sine with rising frequency over ``CHIRP``, with smaller amplitude where it would be too fast."""
    first, last = CHIRP
    rate = (last / first) ** (time / LENGTH) * first
    phase = 2.0 * np.pi * first * LENGTH / np.log(last / first) * ((last / first) ** (time / LENGTH) - 1.0)
    return np.asarray(np.sin(phase) * np.minimum(1.0, 2.0 / (crossing * 2.0 * np.pi * rate)))


def _sines(seed: int) -> Shape:
    """A sum of sines over ``CHIRP`` with phases of this seed, with the largest possible amplitude."""

    def shape(time: Array, crossing: float) -> Array:
        generator = np.random.default_rng(seed)
        rates = np.geomspace(*CHIRP, 8)
        phases = generator.uniform(0.0, 2.0 * np.pi, len(rates))
        total = np.sum(np.sin(2.0 * np.pi * rates * time[:, None] + phases) / rates**0.5, axis=1)
        total /= np.abs(total).max()
        fastest = np.abs(np.diff(total)).max() * RATE
        return np.asarray(total * min(1.0, 2.0 / crossing / fastest))

    return shape


def _then(first: Shape, second: Shape) -> Shape:
    """One in the first half, the other in the second, each at twice the speed if it fills the length."""

    def shape(time: Array, crossing: float) -> Array:
        half = 0.5 * LENGTH
        start, end = first(time, crossing), second(np.maximum(time - half, 0.0), crossing)
        blend = np.clip((time - half) / max(crossing, 0.1), 0.0, 1.0)  # s: no jump
        return np.asarray((1.0 - blend) * start + blend * end)

    return shape


def _shapes() -> dict[str, Shape]:
    """Words -> shape, the chirp first."""

    def creep(time: Array, crossing: float) -> Array:
        return _triangle(time, max(crossing, LENGTH / 2.0))

    def haste(time: Array, crossing: float) -> Array:
        return _triangle(time, crossing)

    plain: dict[str, Shape] = {
        "a chirp": _chirp,
        "a slow ramp up and down": creep,
        "ramps at full speed": haste,
        "a staircase with pauses": _staircase,
        "small steps about three angles": _small_steps,
        "hard steps from end to end": _hard_steps,
    }
    plain |= {f"a sum of sines ({seed + 1})": _sines(seed) for seed in range(SEEDS)}
    plain |= {
        "a slow ramp, then hard steps": _then(creep, _hard_steps),
        "hard steps, then small ones": _then(_hard_steps, _small_steps),
        "a sum of sines, then a slow ramp": _then(_sines(0), creep),
    }
    return plain


def _imagined(leg: Leg, noise: Array, time: Array, command: Array) -> AngleTrial:
    """A trial without readings that follows ``command`` (m, n) rad on q."""
    n = len(leg.joints)
    start = np.tile(command[0], (len(time), 1))
    smoothed = Smoothed(time, start, np.zeros_like(start), noise, np.zeros(len(time), dtype=bool))
    supply = [joint.drive.supply if isinstance(joint.drive, Servo) else 1.0 for joint in leg.joints]
    signals = ServoSignals(time, command, np.tile(supply, (len(time), 1)), np.ones((len(time), n)))
    counts = np.ones((len(time), n), dtype=bool)
    recording = Recording("next", time, start, counts, Conditions(), smoothed, signals=signals)
    return AngleTrial(recording, time, start, counts, held_out=False)
