"""A recorded run-up as runs to simulate: its pieces between switches, and what is known of the motor before the first.

A recording that begins before the switch-on shows a motor at rest: no current, no speed. That rest has no information
on any constant, but it is the state at the switch-on, whose time between two samples is the only unknown. With the
state at the first sample free instead, the rise of the current, which shows the inductance, would be lost. On a supply
that drops under the current the voltage between these two samples is unknown; there the state stays free.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.fit_motor_response import ResponseRun
from synth.hopper.quiet_voltage import DROP_DEVIATIONS, LEAST_DROP, SMALL, driven_pieces
from synth.noise import difference_scale, robust_deviation


def response_runs(run: HopperRecording, ratio: float) -> list[ResponseRun]:
    """Runs of a recording with ``voltage``, ``current`` and the output's ``speed``; ``ratio``: rotor's turns for one.

    The rest before the switch-on is none of them.
    """
    time, recorded = run["time"], run["voltage"]
    measured = np.column_stack([run["current"], ratio * run["speed"]])
    rest, found = _samples_at_rest(recorded, measured), []
    for piece, voltage in driven_pieces(recorded):
        if piece.stop <= rest:
            continue
        known = 0 < rest == piece.start and _is_stiff(recorded[piece], measured[piece, 0])
        within = float(time[rest] - time[rest - 1]) if known else None
        found.append(ResponseRun(time[piece], voltage, measured[piece], within))
    return found


def _samples_at_rest(voltage: Array, measured: Array) -> int:
    """How many first samples are before the switch-on, of a motor at rest; 0 if it moves or is driven."""
    first = int(np.argmax(np.abs(voltage) > SMALL * float(np.max(np.abs(voltage)))))
    columns = (voltage, measured[:, 0], measured[:, 1])
    return first if first > 0 and all(_is_nothing(values, first) for values in columns) else 0


def _is_nothing(values: Array, first: int) -> bool:
    """Whether the first so many of a column (n,) are zero, but for a sensor's noise and offset."""
    noise = robust_deviation(np.diff(values)) / difference_scale(1)
    least = max(LEAST_DROP * float(np.max(np.abs(values))), DROP_DEVIATIONS * noise / float(np.sqrt(first)))
    return abs(float(np.mean(values[:first]))) <= least


def _is_stiff(voltage: Array, current: Array) -> bool:
    """Whether a voltage (n,) V does not drop under the current (n,) A: the slope of its line over the current."""
    off = current - current.mean()
    power = float(off @ off)
    if power == 0.0:
        return True
    slope = float(off @ voltage) / power
    left = voltage - voltage.mean() - slope * off
    deviation = float(np.sqrt(left @ left / len(left) / power))
    drop, error = (size * float(np.ptp(current)) for size in (abs(slope), deviation))
    return bool(drop <= max(LEAST_DROP * float(np.max(np.abs(voltage))), DROP_DEVIATIONS * error))
