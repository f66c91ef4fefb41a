"""Experiment A: jumps on a force plate with encoders, compared with each model's prediction.

Time counts from the motors' switch-on (``switch_on``); takeoff, speed and rise are those of ``measured_jump``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.files.hopper_recordings import PlateJumps
from synth.hopper.measured_jump import (
    MeasuredJump,
    measure,
    refuse_no_push,
    refuse_other_crouch,
    refuse_out_of_reach,
    refuse_still,
)
from synth.hopper.motors import motor_of
from synth.hopper.odd_recording import refuse_odd
from synth.hopper.plate_zero import PlateZero, without_plate_zero
from synth.hopper.switch_on import SwitchOn, from_switch_on
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import JumpOutcome, outcome_of
from synth.parts.catalogs import Catalogue

MODELS_HELD = ("A", "B", "D", "full")
LARGEST = 0.99  # of the angle at which the lower links lock: there its height has no slope
ODD = 0.3  # relative deviation of a refused jump from its repetitions: above a weak battery's effect


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

    ``switched_on`` : of each jump, on its recording's clock; ``plate_zeros`` : of each, subtracted. ``mean_rise`` : m;
    ``rise_reach`` : m, half of its 90 % interval. Jumps recorded alike miss the same peaks of the force, so the mean is
    as uncertain as one of them.
    """

    jumps: list[MeasuredJump]
    switched_on: list[SwitchOn]
    plate_zeros: list[PlateZero]
    comparisons: list[ModelComparison]
    mean_rise: float
    rise_reach: float
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
    weighed = [without_plate_zero(jump, mass * leg.gravity) for jump in project.jumps]
    for jump, _ in weighed:
        refuse_out_of_reach(jump.name, jump["upper link"], leg)
        refuse_no_push(jump, mass * leg.gravity)
        refuse_still(jump.name, jump["upper link"], leg)
    zeros = [zero for _, zero in weighed]
    timed = [from_switch_on(jump, mass * leg.gravity) for jump, _ in weighed]
    jumps = [jump for jump, _ in timed]
    for jump in jumps:
        refuse_other_crouch(jump, leg)
    bent = LARGEST * leg.largest_crouch  # beyond it an encoder's zero, see ``refuse_out_of_reach``

    def height(angle: float) -> float:
        return leg.centre_height(motor, min(angle, bent))

    measured = [
        measure(jump, mass, leg.gravity, height, zero.deviation) for jump, zero in zip(jumps, zeros, strict=True)
    ]
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
    reach = float(np.mean([jump.rise_reach for jump in measured]))
    return Validation(measured, [found for _, found in timed], zeros, comparisons, mean_rise, reach, curves)


def _refuse_odd_jump(jumps: Sequence[MeasuredJump]) -> None:
    """Refuse a jump whose rise, peak force or takeoff time differs from the others'."""
    figures = np.array([[jump.rise, jump.peak_force, jump.takeoff_time] for jump in jumps])

    def missed(index: int) -> tuple[float, float]:
        others = np.delete(figures, index, axis=0)
        away = np.abs(figures / others.mean(axis=0) - 1.0).max(axis=1)
        return float(away[index]), float(np.delete(away, index).max())

    refuse_odd([jump.name for jump in jumps], missed, "rise, peak force or takeoff time", ODD)
