"""Building blocks of compiled effects, inlined into the lane loop, where branch-free code is vectorised.

All dry friction here uses a bristle: it sticks with an elastic deflection of ``presliding``, at least
``LEAST_PRESLIDING``. A larger presliding is intended and follows Dahl's law. In the four cases of LuGre friction in
``tests/blind/test_forms.py``, each a gap of 60 times the noise, a fit leaves 1.0 to 1.2 times the noise; with a bend in
proportion to the joint's motion it left 3.7 to 7.9. When a joint reverses, ``synth.swing.turning_events`` reverses the
friction, at once without presliding, so sliding friction is not smoothed: one swing agrees with the closed form within
1e-6 rad. The remaining error is the bristle's deflection while it holds a joint. With torques of 1 to 20 % of the
spring's at 1 rad it is 2e-4 rad RMS and at most 1e-3 rad in legs of three links, against a presliding of 1e-5 rad. A
bristle costs 1.05 to 2.5 times the steps of a leg without friction, and 4.5 times if strong friction holds a joint.
"""

from __future__ import annotations

from math import asin, sin
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from synth.compiling.inlining import inlined

__all__ = ["bend_that_holds", "bristle", "dahl_share", "held", "inlined", "power", "stribeck_share"]

LEAST_PRESLIDING = 2e-4  # rad, least presliding of a holding bristle; less makes a held joint stiff to integrate
# s, of a bristle that only holds: more makes a held joint stiff to integrate, less lets it oscillate. A softer bristle,
# of an intended presliding, has less in proportion. With all of it a
# viscous torque would hide Dahl's law (``tests/swing/effects/test_dry_friction.py``).
BRISTLE_DAMPING = 0.001
ASYMPTOTE = 1.005  # of Dahl's law, over the friction torque: sliding is reached, and is not stiff


@inlined
def dahl_share(presliding):  # type: ignore[no-untyped-def]
    """1 for a bristle with an intended presliding, 0 for one that only holds, in between just above the least."""
    return max(0.0, min(1.0, 10.0 * (presliding / LEAST_PRESLIDING - 1.0)))


@inlined
def bristle(rate, memory, presliding):  # type: ignore[no-untyped-def]
    """Rate of change of a bristle's bend (memory, -1..1), which follows the motion until the bristle slides.

    With an intended presliding, Dahl's law ``dz/dt = (w - |w| z) / presliding`` (Dahl, TOR-158, 1968; the bristles of
    LuGre: Canudas de Wit et al., IEEE TAC 40 (1995) 419). Its bend relaxes with ``rate / presliding``, ten thousand per
    second, while the joint slides. Its asymptote therefore lies 0.5 % beyond the bound, where the bend then stays. A
    bristle that only holds a joint is elastic, then perfectly plastic (Prandtl's element). A step may carry the bend
    beyond its bound, where the torque is that at the bound; the integrator clips it (``Effect.bristle``).
    """
    sliding = (abs(memory) >= 1.0) & (rate * memory > 0.0)
    share = dahl_share(presliding)
    change = (1.0 + share * (ASYMPTOTE - 1.0)) * rate - share * abs(rate) * memory
    return 0.0 if sliding else change / max(presliding, LEAST_PRESLIDING)


@inlined
def held(memory, change, presliding=0.0):  # type: ignore[no-untyped-def]
    """Share of the friction torque that a bristle exerts at bend z and its rate of change.

    z with an intended presliding, the same as that of ``bristle``; else z (3 - z^2) / 2. The rate damps oscillations of
    a sticking joint, as LuGre's sigma_1 does (Canudas de Wit et al.). The cubic passes into sliding without a kink,
    which saves steps when sixteen lanes begin to slide at different times, and exerts more torque than a linear
    function.
    """
    softer = LEAST_PRESLIDING / max(presliding, LEAST_PRESLIDING)
    damped = memory + BRISTLE_DAMPING * softer * change if abs(memory) < 1.0 else memory
    z = max(-1.0, min(1.0, damped))
    return z * (1.0 + (1.0 - dahl_share(presliding)) * (0.5 - 0.5 * z * z))


@inlined
def bend_that_holds(share):  # type: ignore[no-untyped-def]
    """Bend of a bristle at rest that exerts this ``share`` (-1..1) of its torque, 2 sin(asin(share) / 3).

    It is the inverse of ``held``.
    """
    return 2.0 * sin(asin(max(-1.0, min(1.0, share))) / 3.0)


@inlined
def stribeck_share(rate, speed, fall):  # type: ignore[no-untyped-def]
    """Share of a friction torque that remains at a rate: ``1 - fall + fall exp(-(rate / speed)^2)``.

    exp(-s) is computed as (1 + s/16)^-16, within 2 %, because four products can be vectorised.
    """
    s = 1.0 + (rate / speed) ** 2 / 16.0
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    return 1.0 - fall + fall / s


def _reinterpreted(given: Any, made: Any) -> Any:
    """The same 64 bits as another type."""

    def typed(context, value):  # type: ignore[no-untyped-def]
        def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
            return builder.bitcast(arguments[0], context.get_value_type(made))

        return made(given), code

    return intrinsic(typed)


_bits = _reinterpreted(types.float64, types.int64)
_of_bits = _reinterpreted(types.int64, types.float64)


@inlined
def power(base, exponent):  # type: ignore[no-untyped-def]
    """``base ** exponent`` of a positive base, branch-free, so that a lane loop can be vectorised; within 2e-14.

    ``2 ** (exponent log2(base))``, clipped to 2 ** -1000 and 2 ** 1000. The logarithm uses the series of the inverse
    hyperbolic tangent about the nearest power of two, the exponential its own series (Abramowitz & Stegun, 4.1.27 and
    4.2.1). numba's own function calls the C library for each lane and takes seven times as long.
    """
    bits = _bits(base)
    twos = (bits - 0x3FE6A09E667F3BCD) >> 52  # so that the mantissa lies between sqrt(1/2) and sqrt(2)
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
