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
from synth.hopper.current_zero import is_nothing, samples_at_rest
from synth.hopper.fit_motor_response import ResponseRun
from synth.hopper.quiet_voltage import DROP_DEVIATIONS, LEAST_DROP, driven_pieces


def response_runs(run: HopperRecording, ratio: float) -> list[ResponseRun]:
    """Runs of a recording with ``voltage``, ``current`` and the output's ``speed``; ``ratio``: rotor's turns for one.

    The rest before the switch-on is none of them.
    """
    time, recorded = run["time"], run["voltage"]
    measured = np.column_stack([run["current"], ratio * run["speed"]])
    rest, found = samples_at_rest(run), []
    if rest and not is_nothing(run, "current", rest):
        rest = 0
    for piece, voltage in driven_pieces(recorded):
        if piece.stop <= rest:
            continue
        known = 0 < rest == piece.start and _is_stiff(recorded[piece], measured[piece, 0])
        within = float(time[rest] - time[rest - 1]) if known else None
        found.append(ResponseRun(time[piece], voltage, measured[piece], within))
    return found


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
