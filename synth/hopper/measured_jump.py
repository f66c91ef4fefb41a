"""Takeoff, speed and rise of a jump from the force plate.

Takeoff is when the ground force, once it has risen over the weight, first falls to the plate's zero and stays there;
takeoff speed by impulse, v = integral (N - m g) dt / m; rise of the centre of mass over the crouch, its path in the
push by integrating that speed, plus v^2 / (2 g), with what force is left below the plate's noise. If the landing is
recorded, the flight time t gives v once more, from h_takeoff - h_landing = g t^2 / 2 - v t, with h the height of the
centre of mass over the foot in the two recorded poses: a leg that lands straighter than it took off flies shorter.

The integrals are sums of trapezoids. The push of a small leg lasts some 35 ms and begins with a peak of a few, which
coarse samples miss. What that may amount to is estimated by leaving out every other sample (step doubling): of 1176
jumps by seven designs, sampled at 200 Hz to 5 kHz, the 90 % interval of the rise made from it holds 95 %.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.estimation.intervals import NORMAL90
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.plate_zero import QUIET, quiet_band
from synth.hopper.switch_on import LATE_ANGLE, PUSHED, noise_of, push_begins
from synth.jump.hopper_leg import HopperLeg

ZERO = np.radians(10.0)  # largest error of an encoder's zero
LEAST_MOTION = np.radians(2.0)  # of the upper link; less is not a jump
COARSE = 0.1  # of a rise, which models are often apart: a wider half interval is reported


@dataclass(frozen=True)
class MeasuredJump:
    """One recorded jump; ``takeoff_time`` s after the switch-on, ``peak_force`` N of the push.

    ``rise`` : of the centre of mass over the crouch, m. ``rise_after_takeoff`` : v^2 / (2 g), its part in the air, m;
    ``flight_rise`` : the same from the flight time and the two poses, None if it does not land within the recording.
    ``rise_reach`` : half of the 90 % interval of ``rise``, from the plate's sampling, noise and zero. ``samples`` : of
    the push.
    """

    name: str
    takeoff_time: float
    takeoff_speed: float
    rise: float
    rise_after_takeoff: float
    flight_rise: float | None
    peak_force: float
    start_angle: float
    rise_reach: float
    samples: int

    def sentence(self) -> str:
        """That the plate is sampled too coarsely, for the user; empty where it is not."""
        if self.rise_reach <= COARSE * self.rise:
            return ""
        return (
            f"{self.name}: only {self.samples} samples of the plate are in the push, or they are noisy: the rise of "
            f"{100 * self.rise:.2f} cm is uncertain by {100 * self.rise_reach:.2f} cm (90 %). Record the force at "
            "1 kHz or more before you judge a model by it"
        )


def refuse_out_of_reach(name: str, angle: Array, leg: HopperLeg) -> None:
    """Refuse an upper link's angle (n_time,) rad that is impossible for a leg of this build.

    Raises
    ------
    UserError : it is turned inward, or beyond the locking angle of the lower links, by more than an encoder's zero.
    """
    low, high = float(angle.min()), float(angle.max())
    if low < -ZERO or high > leg.largest_crouch + ZERO:
        text = f"the angle runs from {degrees(low):.4g} to {degrees(high):.4g} deg; links of "
        text += f"{leg.length * 1e3:g} mm fold from 0 to {degrees(leg.largest_crouch):.1f} deg. Are columns "
        raise UserError(Problem(f"{text}exchanged, or is the angle in another unit?", name, key="upper link"))


def refuse_still(name: str, angle: Array, leg: HopperLeg) -> None:
    """Refuse an upper link's angle (n_time,) rad that hardly changes.

    Raises
    ------
    UserError : it turns by less than a jump or a pull-up needs.
    """
    turned = float(np.ptp(angle))
    if turned < LEAST_MOTION:
        text = f"does not move: the upper link turns by only {degrees(turned):.2g} deg{_unit(angle, leg)}"
        raise UserError(Problem(text, name, key="upper link"))


def refuse_other_crouch(jump: HopperRecording, leg: HopperLeg) -> None:
    """Refuse an upper link that does not begin in the design's crouch, where every model begins.

    Parameters
    ----------
    jump : its time counts from the switch-on; one whose beginning is missing is not judged.

    Raises
    ------
    UserError : it begins farther from there than an encoder's zero.
    """
    first, crouch = jump["upper link"][0], leg.start
    if jump["time"][0] <= LATE_ANGLE and abs(first - crouch) > ZERO:
        text = f"begins at {degrees(first):.4g} deg; the design's crouch, where every model begins, is "
        text += (
            f"{degrees(crouch):.4g} deg{_unit(jump['upper link'], leg)}. Write the crouch that the leg jumped from in "
        )
        raise UserError(Problem(f"{text}the design, under leg", jump.name, key="upper link"))


def _unit(angle: Array, leg: HopperLeg) -> str:
    """A question, where the first angle would be the crouch if its degrees were radians."""
    return "; is it in radians under [deg]?" if abs(degrees(angle[0]) - leg.start) < ZERO else ""


def refuse_no_push(jump: HopperRecording, weight: float) -> None:
    """Refuse a recording whose ground force does not exceed the weight (N) as a push does.

    Raises
    ------
    UserError : it contains no jump.
    """
    peak = float(jump["ground force"].max())
    if peak < PUSHED * weight:
        text = f"contains no jump: the plate's force never exceeds {PUSHED:g} times the weight of {weight:.3g} N (peak "
        raise UserError(Problem(f"{text}{peak:.3g} N)", jump.name, key="ground force"))


def measure(
    jump: HopperRecording,
    mass: float,
    gravity: float,
    height: Callable[[float], float] | None = None,
    zero_deviation: float = 0.0,
) -> MeasuredJump:
    """Takeoff, speed and rise of one recording that starts at rest in the crouch when the motors are switched on.

    Parameters
    ----------
    jump : its force counts from the plate's zero, see ``plate_zero``.
    mass : kg, of the leg; it counts as exact.
    gravity : m/s^2.
    height : of the centre of mass over the foot, m, at an upper link's angle, rad; None: as if it landed in the pose
        of its takeoff.
    zero_deviation : N, standard error of the plate's zero.

    Raises
    ------
    UserError : there is no push, or the foot does not leave the plate.
    """
    time, force = jump["time"], jump["ground force"]
    weight = mass * gravity
    quiet = np.abs(force) < quiet_band(force, weight)  # nothing stands on the plate
    refuse_no_push(jump, weight)
    begin = push_begins(force, weight)
    takeoff = _first_quiet(time, quiet, begin)
    if takeoff is None:
        peak = f"weight {weight:.3g} N, peak {force.max():.3g} N"
        text = f"contains no jump: the plate's force never returns to zero after a push ({peak})"
        raise UserError(Problem(text, jump.name, key="ground force"))
    push = slice(0, takeoff + 1)
    acceleration = (force - weight) / mass
    speed, _ = _speed_and_way(time[push], acceleration[push])
    air = speed**2 / (2 * gravity)
    # Below the noise the foot may still push: up to the first sample without force the rise is summed. In the air it
    # does not matter where the sum ends.
    end = slice(0, takeoff + 1 + int(np.argmax(force[takeoff:] <= 0.0)))
    rise = _risen(time[end], acceleration[end], gravity)
    reach = _rise_reach(time[end], acceleration[end], begin, gravity, (noise_of(force) / mass, zero_deviation / mass))
    landed = np.flatnonzero(~quiet[takeoff:])
    flight = None
    if len(landed):
        ends = [takeoff, takeoff + int(landed[0])]
        poses = jump["upper link"][ends]
        sunk = 0.0 if height is None else height(float(poses[0])) - height(float(poses[1]))
        flight = _flight_rise(float(np.diff(time[ends])[0]), sunk, gravity)
    return MeasuredJump(jump.name, float(time[takeoff]), speed, rise, air, flight, float(force[push].max()),
                        float(jump["upper link"][0]), reach, takeoff)  # fmt: skip


def _flight_rise(flown: float, sunk: float, gravity: float) -> float | None:
    """v^2 / (2 g), m, of a flight of so many s that ends ``sunk`` m below its start over the foot; None if none."""
    speed = 0.5 * gravity * flown - sunk / flown
    return speed**2 / (2.0 * gravity) if speed > 0.0 else None


def _speed_and_way(time: Array, acceleration: Array) -> tuple[float, float]:
    """Last speed, m/s, and way, m, of the centre of mass from its acceleration (n,) m/s^2, by trapezoids."""
    speed = np.concatenate([[0.0], np.cumsum(_middle(acceleration) * np.diff(time))])
    return float(speed[-1]), float(np.sum(_middle(speed) * np.diff(time)))


def _risen(time: Array, acceleration: Array, gravity: float) -> float:
    """Rise of the centre of mass, m: its way so far, and v^2 / (2 g) from there."""
    speed, way = _speed_and_way(time, acceleration)
    return way + speed**2 / (2 * gravity)


def _rise_reach(time: Array, acceleration: Array, begin: int, gravity: float, deviations: tuple[float, float]) -> float:
    """Half of the rise's 90 % interval, m, from four independent deviations.

    The change by leaving out every other sample, which at least doubles a trapezoid sum's error; when the force rises
    between the samples before and at ``begin``, uniform; and the ``deviations`` of the plate's noise, by sample, and
    zero, the same in all, m/s^2.
    """
    noise, zero = deviations
    last = len(time) - 1
    every = np.arange(last + 1)
    halves = [np.unique(np.concatenate([[0], every[first:last:2], [last]])) for first in (1, 2)]
    full, *half = (_risen(time[kept], acceleration[kept], gravity) for kept in (every, *halves))
    missed = max(abs(one - full) for one in half)
    # What one sample's error adds to the speed, and from there to the path in the push and in the air.
    later = time[-1] - time + _speed_and_way(time, acceleration)[0] / gravity
    before = max(begin - 1, 0)
    risen = 0.5 * (acceleration[begin] - acceleration[before]) * (time[begin] - time[before]) * later[begin]
    adds = np.gradient(time) * later
    scatter, shift = noise * float(np.linalg.norm(adds)), zero * float(np.sum(adds))
    return NORMAL90 * float(np.linalg.norm([missed, risen / np.sqrt(3.0), scatter, shift]))


def _middle(values: Array) -> Array:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _first_quiet(time: Array, quiet: Mask, after: int) -> int | None:
    """First sample after ``after`` from which the plate is quiet for ``QUIET``."""
    for index in range(after, len(time)):
        end = int(np.searchsorted(time, time[index] + QUIET))
        if end < len(time) and quiet[index:end].all():
            return index
    return None
