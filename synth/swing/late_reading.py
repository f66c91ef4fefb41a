"""Late and filtered readings of many lanes, compiled; formulas and arguments as of ``latency.read``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synth.compiling.compiled import compiled_when_called

_options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
LEAST_LAG = 1e-9  # s: the reading without a filter, to rounding


@compiled_when_called(**_options)
def later(time, rotation, rate, delay, out):  # type: ignore[no-untyped-def]
    """Write the rotation ``delay`` (n_lane,) s earlier to ``out`` (m, n_lane)."""
    last = len(time) - 2
    for lane in range(rotation.shape[1]):
        i = 0
        for k in range(len(time)):
            past = time[k] - delay[lane]
            while i < last and time[i + 1] <= past:
                i += 1
            if past < time[0]:
                bend = (rate[1, lane] - rate[0, lane]) / (time[1] - time[0])
                out[k, lane] = _earlier(past - time[0], rotation[0, lane], rate[0, lane], bend)
                continue
            step = time[i + 1] - time[i]
            u = (past - time[i]) / step
            q0, w0 = rotation[i, lane], rate[i, lane] * step
            rise, w1 = rotation[i + 1, lane] - q0, rate[i + 1, lane] * step
            # The cubic with these end values and slopes, by Horner's rule.
            out[k, lane] = q0 + u * (w0 + u * (3.0 * rise - 2.0 * w0 - w1 + u * (w0 + w1 - 2.0 * rise)))


@compiled_when_called(**_options)
def _earlier(lead, rotation, rate, bend):  # type: ignore[no-untyped-def]
    """Rotation at ``lead`` s < 0 before the first sample, from its initial rate and acceleration.

    A joint that accelerates was released when its rate was zero and was at rest before. A joint that decelerates was
    moving; but the slower it is, the more likely it was released and the estimated rate has the wrong sign. Its motion
    is therefore reduced for small rates. Otherwise the reading would be discontinuous where the rate changes sign, and
    a fit could not pass this point.
    """
    if bend == 0.0:
        return rotation + lead * rate
    since = rate / bend  # s since the rate was zero; negative: until it will be
    if since >= 0.0:
        lead = max(lead, -since)
        return rotation + lead * rate + 0.5 * lead * lead * bend
    share = since * since / (since * since + lead * lead)
    return rotation + share * (lead * rate + 0.5 * lead * lead * bend)


@compiled_when_called(**_options)
def filter_reading(time, reading, lag):  # type: ignore[no-untyped-def]
    """Pass the reading (m, n_lane), in place, through a first-order filter of time constant ``lag`` (n_lane,) s.

    Initially at rest. Exact for a reading that is linear between its samples.
    """
    n_lane = reading.shape[1]
    before, behind = reading[0].copy(), np.zeros(n_lane)  # the last input; the output minus the input
    for k in range(len(time) - 1):
        step = time[k + 1] - time[k]
        for lane in range(n_lane):
            constant = max(lag[lane], LEAST_LAG)
            fade, now = math.exp(-step / constant), reading[k + 1, lane]
            behind[lane] = fade * behind[lane] + (fade - 1.0) * constant * (now - before[lane]) / step
            before[lane] = now
            reading[k + 1, lane] = now + behind[lane]
