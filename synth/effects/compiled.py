"""How an effect's torque is compiled: inlined into the lane loop, where branch-free code becomes vector code.

The bristle is the element of all dry friction here: true sticking, with a give of ``presliding``, at least
``LEAST_GIVE``, while it holds. Where a joint turns back ``synth.model.turning`` turns the friction over, at once if
there is no presliding, so that nothing is smoothed while it slides: one swing comes out within 1e-6 rad of the closed
form. What is left is the give while a joint is held: with torques of 1 to 20 % of the spring's at 1 rad 2e-4 rad RMS
and 1e-3 rad at most in legs of three links, against a give of 1e-5 rad. It costs 1.05 to 2.5 times the steps of a leg
without friction, 4.5 times where a strong one holds a joint.
"""

from __future__ import annotations

from math import asin, sin
from typing import Any

from numba import njit

inlined: Any = njit(inline="always", fastmath=True, error_model="numpy")

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
