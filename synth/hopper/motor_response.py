"""Current and speed of a motor under a voltage, from sample to sample in closed form, compiled.

    L di/dt = V - R i - K w,        J dw/dt = K i - f0 sign(w) - b w

with w the rotor's speed; V is linear between samples. While w keeps its sign the equations are linear: the steady
motion under the ramp, plus the matrix exponential of what is off it. The rotor stands while its torque is below f0.
Where it starts, stops or turns within a sample is found by bisection.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling.compiled import compiled_when_called

CONSTANTS = ("resistance", "inductance", "back_emf", "friction", "viscous", "rotor_inertia")  # of a lane, in order
MOST_TURNS = 8  # starts, stops and turns in one sample; a chatter of more is left as it is
BISECTIONS = 50  # of a sample's length: to rounding
_options: dict[str, Any] = {"error_model": "numpy", "nogil": True}


@compiled_when_called(**_options)
def _current_at_rest(i, v, slope, h, p):  # type: ignore[no-untyped-def]
    """The current after h s with the rotor at rest."""
    rate = p[0] / p[1]
    steady = (v - slope / rate) / p[0]
    return steady + slope / p[0] * h + (i - steady) * math.exp(-rate * h)


@compiled_when_called(**_options)
def _turning_rotor(i, w, v, slope, sign, h, p):  # type: ignore[no-untyped-def]
    """Current and speed after h s, friction against ``sign``; the matrix exponential of a 2x2 matrix."""
    a, b, c, d = -p[0] / p[1], -p[2] / p[1], p[2] / p[5], -p[4] / p[5]
    det = a * d - b * c
    # The steady motion x = x0 + g t under the ramp: A g = -(slope / L, 0), A x0 = g - (v / L, -sign f0 / J).
    gi, gw = -d * slope / p[1] / det, c * slope / p[1] / det
    ri, rw = gi - v / p[1], gw + sign * p[3] / p[5]
    si, sw = (d * ri - b * rw) / det, (a * rw - c * ri) / det
    oi, ow = i - si, w - sw
    mean = 0.5 * (a + d)
    square = mean * mean - det
    root = math.sqrt(abs(square))
    if square > 0.0 and root * h > 1.0:
        fast = mean - root
        slow = det / fast  # without cancellation
        x, y = math.exp(slow * h), math.exp(fast * h)
        even, odd = (slow * y - fast * x) / (slow - fast), (x - y) / (slow - fast)
    else:
        grown = math.exp(mean * h)
        if square > 0.0:
            odd = grown * (math.sinh(root * h) / root)
            even = grown * math.cosh(root * h) - mean * odd
        elif square < 0.0:
            odd = grown * (math.sin(root * h) / root)
            even = grown * math.cos(root * h) - mean * odd
        else:
            odd = grown * h
            even = grown - mean * odd
    ei, ew = even * oi + odd * (a * oi + b * ow), even * ow + odd * (c * oi + d * ow)
    return si + gi * h + ei, sw + gw * h + ew


@compiled_when_called(**_options)
def _sample(i, w, v, slope, h, p):  # type: ignore[no-untyped-def]
    """Current and speed at the next sample, h s later."""
    for _ in range(MOST_TURNS):
        sign = math.copysign(1.0, w)
        stands = w == 0.0 and abs(p[2] * i) <= p[3]
        if w == 0.0:
            sign = math.copysign(1.0, i)
        if stands:
            next_i, next_w = _current_at_rest(i, v, slope, h, p), 0.0
            if abs(p[2] * next_i) <= p[3]:
                return next_i, next_w
        else:
            next_i, next_w = _turning_rotor(i, w, v, slope, sign, h, p)
            if next_w * sign >= 0.0:
                return next_i, next_w
        low, high = 0.0, h
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if stands:
                past = abs(p[2] * _current_at_rest(i, v, slope, middle, p)) > p[3]
            else:
                past = _turning_rotor(i, w, v, slope, sign, middle, p)[1] * sign < 0.0
            if past:
                high = middle
            else:
                low = middle
        if stands:
            i = _current_at_rest(i, v, slope, high, p)
        else:
            i = _turning_rotor(i, w, v, slope, sign, high, p)[0]
            w = 0.0
        v += slope * high
        h -= high
        if h <= 0.0:
            return i, w
    return next_i, next_w


@compiled_when_called(**_options)
def _respond(time, voltage, constants, start, out):  # type: ignore[no-untyped-def]
    for lane in range(out.shape[2]):
        p = constants[:, lane]
        i, w = start[0, lane], start[1, lane]
        out[0, 0, lane], out[0, 1, lane] = i, w
        for k in range(len(time) - 1):
            h = time[k + 1] - time[k]
            i, w = _sample(i, w, voltage[k], (voltage[k + 1] - voltage[k]) / h, h, p)
            out[k + 1, 0, lane], out[k + 1, 1, lane] = i, w


def motor_responses(time: Array, voltage: Array, constants: Array, start: Array) -> Array:
    """(n_time, 2, n_lane) current A and rotor's speed rad/s under ``voltage`` (n_time,) V.

    ``constants`` (6, n_lane): in the order of ``CONSTANTS``, SI. ``start`` (2, n_lane): at the first sample.
    """
    out = np.empty((len(time), 2, constants.shape[1]))
    lanes, begun = np.ascontiguousarray(constants, float), np.ascontiguousarray(start, float)
    _respond(np.ascontiguousarray(time, float), np.ascontiguousarray(voltage, float), lanes, begun, out)
    return out
