"""Experiment A: jumps on a force plate with encoders, compared with each model's prediction.

From a recording: time counts from the motors' switch-on (``switch_on``); takeoff is when the ground force, once it has
risen over the weight, first falls to the plate's zero and stays there; takeoff speed by impulse, v = integral (N - m g)
dt / m; rise of the centre of mass over the crouch, its path in the push by integrating that speed, plus v^2 / (2 g). If
the landing is recorded, the flight time t gives v^2 / (2 g) once more, as t^2 g / 8: the rise after takeoff, if the leg
lands in the pose in which it took off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording, PlateJumps
from synth.hopper.motors import motor_of
from synth.hopper.odd_recording import refuse_odd
from synth.hopper.switch_on import PUSHED, SwitchOn, from_switch_on, push_begins
from synth.jump.hopper_leg import HopperLeg
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import JumpOutcome, outcome_of
from synth.parts.catalogs import Catalogue

MODELS_HELD = ("A", "B", "D", "full")
ODD = 0.3  # relative deviation of a refused jump from its repetitions: above a weak battery's effect
ZERO = np.radians(10.0)  # largest error of an encoder's zero
QUIET = 0.02  # s, least time that a foot in the air leaves the plate quiet


@dataclass(frozen=True)
class MeasuredJump:
    """One recorded jump; ``takeoff_time`` s after the switch-on, ``peak_force`` N of the push.

    ``rise`` : of the centre of mass over the crouch, m. ``rise_after_takeoff`` : v^2 / (2 g), its part in the air, m;
    ``flight_rise`` : the same from the flight time, None if it does not land within the recording.
    """

    name: str
    takeoff_time: float
    takeoff_speed: float
    rise: float
    rise_after_takeoff: float
    flight_rise: float | None
    peak_force: float
    start_angle: float


@dataclass(frozen=True)
class ModelComparison:
    """One model: its outcome, and its RMS error of force (N) and upper link angle (rad) during the push."""

    model: str
    outcome: JumpOutcome
    force_error: float
    angle_error: float


@dataclass(frozen=True, eq=False)
class Validation:
    """All jumps, the models, and the recorded and predicted curves of the first jump for a figure.

    ``switched_on`` : of each jump, on its recording's clock.
    """

    jumps: list[MeasuredJump]
    switched_on: list[SwitchOn]
    comparisons: list[ModelComparison]
    mean_rise: float
    curves: dict[str, Array]


def validate(project: PlateJumps, catalogue: Catalogue) -> Validation:
    """Compare the models with the jumps.

    Raises
    ------
    UserError : an unknown motor, or a recording without a jump.
    """
    motor = motor_of(catalogue.find_motor(project.motor), project.design.motor_options)
    leg = project.design.leg.with_length(project.length)
    mass = leg.total_mass(motor)
    for jump in project.jumps:
        refuse_out_of_reach(jump.name, jump["upper link"], leg)
        _refuse_no_push(jump, mass * leg.gravity)
    timed = [from_switch_on(jump, mass * leg.gravity) for jump in project.jumps]
    jumps = [jump for jump, _ in timed]
    measured = [measure(jump, mass, leg.gravity) for jump in jumps]
    _refuse_odd_jump(measured)
    jumper, layout = compiled_jump(leg.bending), LAYOUTS[leg.bending]
    comparisons, curves = [], {}
    for name in MODELS_HELD:
        parameters = lane(leg, motor, project.design.contact, MODELS[name])
        outcome = outcome_of(jumper.run(parameters[:, None])[:, 0])
        trace = jumper.trace(parameters)
        predicted = {"normal": trace[:, 1 + layout.row("normal")], "angle": trace[:, 1 + layout.row("angle")]}
        force, angle = [], []
        for jump, found in zip(jumps, measured, strict=True):
            push = jump["time"] <= found.takeoff_time
            time = jump["time"][push]
            force.append(np.interp(time, trace[:, 0], predicted["normal"]) - jump["ground force"][push])
            angle.append(np.interp(time, trace[:, 0], predicted["angle"]) - jump["upper link"][push])
        rms = [float(np.sqrt(np.mean(np.concatenate(errors) ** 2))) for errors in (force, angle)]
        comparisons.append(ModelComparison(name, outcome, rms[0], rms[1]))
        first = jumps[0]["time"]
        curves[f"ground force {name} [N]"] = np.interp(first, trace[:, 0], predicted["normal"], right=0.0)
    curves = {
        "time [s]": jumps[0]["time"],
        "ground force measured [N]": jumps[0]["ground force"],
        **curves,
    }
    mean_rise = float(np.mean([jump.rise for jump in measured]))
    return Validation(measured, [found for _, found in timed], comparisons, mean_rise, curves)


def _refuse_odd_jump(jumps: Sequence[MeasuredJump]) -> None:
    """Refuse a jump whose rise, peak force or takeoff time differs from the others'."""
    figures = np.array([[jump.rise, jump.peak_force, jump.takeoff_time] for jump in jumps])

    def missed(index: int) -> tuple[float, float]:
        others = np.delete(figures, index, axis=0)
        away = np.abs(figures / others.mean(axis=0) - 1.0).max(axis=1)
        return float(away[index]), float(np.delete(away, index).max())

    refuse_odd([jump.name for jump in jumps], missed, "rise, peak force or takeoff time", ODD)


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


def _refuse_no_push(jump: HopperRecording, weight: float) -> None:
    peak = float(jump["ground force"].max())
    if peak < PUSHED * weight:
        text = f"contains no jump: the plate's force never exceeds {PUSHED:g} times the weight of {weight:.3g} N (peak "
        raise UserError(Problem(f"{text}{peak:.3g} N)", jump.name, key="ground force"))


def measure(jump: HopperRecording, mass: float, gravity: float) -> MeasuredJump:
    """Takeoff, speed and rise of one recording that starts at rest in the crouch when the motors are switched on.

    Raises
    ------
    UserError : there is no push, or the foot does not leave the plate.
    """
    time, force = jump["time"], jump["ground force"]
    weight = mass * gravity
    noise = 1.4826 * float(np.median(np.abs(np.diff(force)))) / np.sqrt(2)  # 1.4826: median to standard deviation
    # Nothing stands on the plate: within five deviations of zero, or a twentieth of the weight.
    quiet = np.abs(force) < max(5.0 * noise, 0.05 * weight)
    _refuse_no_push(jump, weight)
    takeoff = _first_quiet(time, quiet, push_begins(force, weight))
    if takeoff is None:
        peak = f"weight {weight:.3g} N, peak {force.max():.3g} N"
        text = f"contains no jump: the plate's force never returns to zero after a push ({peak})"
        raise UserError(Problem(text, jump.name, key="ground force"))
    push = slice(0, takeoff + 1)
    speed = np.concatenate([[0.0], np.cumsum(_middle(force[push] - weight) * np.diff(time[push]))]) / mass
    way = float(np.sum(_middle(speed) * np.diff(time[push])))
    landed = np.flatnonzero(~quiet[takeoff:])
    flight = None
    if len(landed):
        flight = float(time[takeoff + landed[0]] - time[takeoff]) ** 2 * gravity / 8.0
    top = float(speed[-1])
    air = top**2 / (2 * gravity)
    return MeasuredJump(jump.name, float(time[takeoff]), top, way + air, air, flight, float(force[push].max()),
                        float(jump["upper link"][0]))  # fmt: skip


def _middle(values: Array) -> Array:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _first_quiet(time: Array, quiet: Array, after: int) -> int | None:
    """First sample after ``after`` from which the plate is quiet for ``QUIET``."""
    for index in range(after, len(time)):
        end = int(np.searchsorted(time, time[index] + QUIET))
        if end < len(time) and quiet[index:end].all():
            return index
    return None
