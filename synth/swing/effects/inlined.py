"""How an effect's torque is compiled: inlined into the lane loop, where branch-free code becomes vector code.

The bristle is the element of all dry friction here: true sticking, with a give of ``presliding``, at least
``LEAST_GIVE``, while it holds. Where a joint turns back, ``synth.swing.turning_events`` reverses the friction, at
once if there is no presliding, so that nothing is smoothed while it slides: one swing agrees with the closed form
within 1e-6 rad. The remaining error is the bristle's give while a joint is held: with torques of 1 to 20 % of the
spring's at 1 rad it is 2e-4 rad RMS and at most 1e-3 rad in legs of three links, against a give of 1e-5 rad. The
bristle costs 1.05 to 2.5 times the steps of a leg without friction, and 4.5 times where strong friction holds a joint.
"""

from __future__ import annotations

from math import asin, sin
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from synth.compiling.inlining import inlined

__all__ = ["bend_that_holds", "bristle", "held", "inlined", "power", "stribeck_share"]

LEAST_GIVE = 2e-4  # rad, with which a bristle holds at least; less makes a held joint stiff to integrate
BRISTLE_DAMPING = 0.001  # s; more makes a held joint stiff to integrate, less lets it ring


@inlined
def bristle(rate, memory, presliding):  # type: ignore[no-untyped-def]
    """Rate of change of a bristle's bend (memory, -1..1): bent by motion, until it slides.

    Elastic, then perfectly plastic (Prandtl's element): nothing stiff happens while the joint slides, as it does in
    Dahl's smooth law, whose bend settles with ``rate / presliding``, ten thousand times a second. A step may carry the
    bend beyond its bound, where the torque is the bound's; the integrator puts it back (``Effect.bristle``).
    """
    sliding = (abs(memory) >= 1.0) & (rate * memory > 0.0)
    return 0.0 if sliding else rate / max(presliding, LEAST_GIVE)


@inlined
def held(memory, change):  # type: ignore[no-untyped-def]
    """Share of the friction torque that a bristle's bend z and its rate of change give: z (3 - z^2) / 2.

    The rate damps what would otherwise ring on while the joint sticks. The cubic meets sliding with no kink, which
    saves steps where sixteen lanes begin to slide at different moments, and holds more of the torque than a line does.
    """
    damped = memory + BRISTLE_DAMPING * change if abs(memory) < 1.0 else memory
    z = max(-1.0, min(1.0, damped))
    return z * (1.5 - 0.5 * z * z)


@inlined
def bend_that_holds(share):  # type: ignore[no-untyped-def]
    """Bend of a bristle at rest that gives this share (-1..1) of its torque: the inverse of ``held``, 2 sin(asin/3)."""
    return 2.0 * sin(asin(max(-1.0, min(1.0, share))) / 3.0)


@inlined
def stribeck_share(rate, speed, fall):  # type: ignore[no-untyped-def]
    """Share of a friction that is left at a rate: ``1 - fall + fall exp(-(rate / speed)^2)``.

    The exponential of -s as (1 + s/16)^-16, to 2 %: four products stay vector code.
    """
    s = 1.0 + (rate / speed) ** 2 / 16.0
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    return 1.0 - fall + fall / s


def _reinterpreted(given: Any, made: Any) -> Any:
    """The same 64 bits read as another type."""

    def typed(context, value):  # type: ignore[no-untyped-def]
        def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
            return builder.bitcast(arguments[0], context.get_value_type(made))

        return made(given), code

    return intrinsic(typed)


_bits = _reinterpreted(types.float64, types.int64)
_of_bits = _reinterpreted(types.int64, types.float64)


@inlined
def power(base, exponent):  # type: ignore[no-untyped-def]
    """``base ** exponent`` of a positive base, branch-free, so that a lane loop stays vector code; within 2e-14.

    ``2 ** (exponent log2(base))``, kept between 2 ** -1000 and 2 ** 1000. The logarithm by the series of the inverse
    hyperbolic tangent about the nearest power of two, the exponential by its own (Abramowitz & Stegun, 4.1.27, 4.2.1).
    numba's own calls the C library, lane by lane: seven times as long.
    """
    bits = _bits(base)
    twos = (bits - 0x3FE6A09E667F3BCD) >> 52  # such that what is left lies between sqrt(1/2) and sqrt(2)
    left = _of_bits(bits - (twos << 52))
    s = (left - 1.0) / (left + 1.0)
    z = s * s
    series = 1.0 / 13.0 + z * (1.0 / 15.0 + z * (1.0 / 17.0 + z * (1.0 / 19.0)))
    series = 1.0 / 5.0 + z * (1.0 / 7.0 + z * (1.0 / 9.0 + z * (1.0 / 11.0 + z * series)))
    logarithm = np.float64(np.int32(twos)) + 2.8853900817779268 * (s + s * z * (1.0 / 3.0 + z * series))
    wanted = max(-1000.0, min(1000.0, exponent * logarithm))
    whole = np.floor(wanted + 0.5)
    f = 0.6931471805599453 * (wanted - whole)
    series = 1.0 / 5040.0 + f * (1.0 / 40320.0 + f * (1.0 / 362880.0 + f * (1.0 / 3628800.0 + f * (1.0 / 39916800.0))))
    series = 1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0 + f * series)))
    return (1.0 + f * (1.0 + f * (0.5 + f * series))) * _of_bits((np.int64(np.int32(whole)) + 1023) << 52)
