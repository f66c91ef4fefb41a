"""Jump height from a video's CSV and current from a meter's, compared with each model's prediction.

A video follows one point, the hips or the foot, whose height is relative to its initial level. A foot's is the
clearance. A meter logs the total current of both motors, beside which it may show that of other electronics, or an
offset: what it shows before the push is subtracted. Of the rest the peak is taken, and the charge until the current has
finally fallen to a tenth of the peak. The motors often stay on in flight, and after it; a model's peak and charge are
those of as many seconds with its motors on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import PlateJumps
from synth.hopper.motors import motor_of
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import Jumper, compiled_jump
from synth.jump.outcomes import outcome_of
from synth.parts.catalogs import Catalogue
from synth.units import quantity

MODELS_HELD = ("A", "B", "D", "full")
LEAST_JUMP = 2e-3  # m; a smaller rise is the camera's scatter
LEVEL = 0.1  # of the samples before the fastest rise, whose median is the initial level
IDLE = 0.1  # of the peak, below which the motors are off
NO_FALL = 1e9  # m/s; no leg falls so fast, so that a trace goes on through flight and landing


@dataclass(frozen=True)
class SeenJumps:
    """Heights by point and currents, each with a recording's name and value in SI; and every model's.

    A model that folds up before the motors are off has no peak and no charge.
    """

    heights: Mapping[str, Mapping[str, float]]  # point -> file -> m
    peaks: Mapping[str, float]  # file -> A
    charges: Mapping[str, float]  # file -> A s
    lasting: Mapping[str, float]  # file -> s, for which the motors are on
    models: Mapping[str, Mapping[str, float]]

    def as_json(self) -> dict[str, Any]:
        """Measured values with their mean, and each model's."""
        found: dict[str, Any] = {}
        for point, each in self.heights.items():
            found[f"height_of_{point}"] = self._measured_beside_models(each, "m", point)
        if self.peaks:
            found["peak_current"] = self._measured_beside_models(self.peaks, "A", "peak_current")
            found["charge"] = self._measured_beside_models(self.charges, "A*s", "charge")
            for item in found["charge"]["measured"]:
                item["lasting"] = quantity(self.lasting[item["file"]], "s")
        return found

    def _measured_beside_models(self, each: Mapping[str, float], unit: str, key: str) -> dict[str, Any]:
        mean = float(np.mean(list(each.values())))
        models = {name: item[key] for name, item in self.models.items() if key in item}
        return {
            "measured": [{"file": name, "value": quantity(value, unit)} for name, value in each.items()],
            "mean": quantity(mean, unit),
            "models": {n: {"value": quantity(v, unit), "over_measured": v / mean - 1.0} for n, v in models.items()},
        }


def seen_jumps(project: PlateJumps, catalogue: Catalogue) -> SeenJumps:
    """Read heights and currents, and compute those of the models.

    Raises
    ------
    UserError : a video without a jump, or a meter's log without a push.
    """
    motor = motor_of(catalogue.find_motor(project.motor), project.design.motor_options)
    leg = project.design.leg.with_length(project.length)
    jumper, layout = compiled_jump(leg.bending), LAYOUTS[leg.bending]
    meters = {recording.name: push_current(recording.name, recording["time"], recording["current"])
              for recording in project.meters}  # fmt: skip
    lasting = {name: value[2] for name, value in meters.items()}
    models = {}
    for name in MODELS_HELD:
        parameters = lane(leg, motor, project.design.contact, MODELS[name])
        outcome = outcome_of(jumper.run(parameters[:, None])[:, 0])
        hips = jumper.trace(parameters)[:, 1 + layout.row("height")]
        models[name] = {"foot": outcome.clearance, "hips": float(hips.max() - hips[0])}
        if lasting:
            models[name] |= _current_drawn(jumper, parameters, list(lasting.values()))
    heights: dict[str, dict[str, float]] = {}
    for point, recording in project.videos:
        heights.setdefault(point, {})[recording.name] = rise_of_point(recording.name, recording["height"])
    peaks = {name: value[0] for name, value in meters.items()}
    return SeenJumps(heights, peaks, {name: value[1] for name, value in meters.items()}, lasting, models)


def _current_drawn(jumper: Jumper, parameters: Array, lasting: Sequence[float]) -> dict[str, float]:
    """Peak current, A, and charge, A s, of one lane, means over motors on for these times, s; empty if it folds up."""
    trace = jumper.trace(parameters, duration=max(lasting), fall=NO_FALL)
    time, drawn = trace[:, 0], trace[:, 1 + jumper.layout.row("drawn")]
    if time[-1] < max(lasting):
        return {}
    peaks, charges = [], []
    for end in lasting:
        on = time < end
        until = np.append(time[on], end)
        current = np.append(drawn[on], np.interp(end, time, drawn))
        peaks.append(float(current.max()))
        charges.append(float(np.trapezoid(current, until)))
    return {"peak_current": float(np.mean(peaks)), "charge": float(np.mean(charges))}


def rise_of_point(name: str, height: Sequence[float] | np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """Rise of a point over its initial level, m: from the median before the jump to the highest sample.

    Raises
    ------
    UserError : it hardly moves, or the video starts in the air.
    """
    seen = np.asarray(height, dtype=float)
    top = int(np.argmax(seen))
    before = seen[: max(3, int(LEVEL * top))]
    level = float(np.median(before))
    rise = float(seen[top] - level)
    if rise < LEAST_JUMP:
        text = f"rises by {1e3 * rise:.2g} mm only; is it a jump, is height positive upward, and is its unit right?"
        raise UserError(Problem(text, name, key="height"))
    if top < 3 or np.ptp(before) > 0.5 * rise:
        raise UserError(Problem("begins during the jump; it needs a few frames at rest before it", name, key="height"))
    return rise


def push_current(
    name: str, time: np.ndarray[Any, np.dtype[np.float64]], current: np.ndarray[Any, np.dtype[np.float64]]
) -> tuple[float, float, float]:
    """The motors' peak current, A, their charge while they are on, A s, and for how long they are, s.

    Raises
    ------
    UserError : there is no push.
    """
    idle = float(np.median(current[: max(3, len(current) // 20)]))  # the first twentieth of the log
    drawn = current - idle
    peak = float(drawn.max())
    if peak <= 0 or peak < 3 * float(np.std(drawn[: max(3, len(drawn) // 20)])):  # three deviations of the idle current
        raise UserError(Problem("shows no push; is the current's sign right?", name, key="current"))
    on = np.flatnonzero(drawn > IDLE * peak)
    push = slice(int(on[0]), int(on[-1]) + 1)
    on_for = float(time[on[-1]] - time[on[0]])
    return peak, float(np.trapezoid(drawn[push], time[push])), on_for
