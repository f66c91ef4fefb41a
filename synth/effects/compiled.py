"""How an effect's torque is compiled: inlined into the lane loop, where branch-free code becomes vector code.

The bristle is the element of all dry friction here. Its numbers, measured (``tests/effects/test_dry_friction.py``): a
swing that friction stops keeps within 0.2 presliding of one whose friction turns over at once, and at rest it does not
creep. A joint that turns back and sticks costs 1.4 to 2.5 times the steps of one without friction.
"""

from __future__ import annotations

from typing import Any

from numba import njit

inlined: Any = njit(inline="always", fastmath=True, error_model="numpy")

BRISTLE_DAMPING = 0.001  # s; more makes a held joint stiff to integrate, less lets it ring


@inlined
def bristle(rate, memory, presliding):  # type: ignore[no-untyped-def]
    """Rate of change of a bristle's bend (memory, -1..1): bent by motion, until it slides.

    Elastic, then perfectly plastic (Prandtl's element): nothing stiff happens while the joint slides, as it does in
    Dahl's smooth law, whose bend settles with ``rate / presliding``, ten thousand times a second. A step may carry the
    bend beyond its bound, where the torque is the bound's; the integrator puts it back (``Effect.bound``).
    """
    sliding = (abs(memory) >= 1.0) & (rate * memory > 0.0)
    return 0.0 if sliding else rate / presliding


@inlined
def held(memory, change):  # type: ignore[no-untyped-def]
    """Share of the friction torque that a bristle's bend z and its rate of change give: z (3 - z^2) / 2.

    The rate damps what would otherwise ring on while the joint sticks; cut off at one, it turns the torque over at
    once when the joint turns back, as dry friction does. The cubic meets sliding with no kink, which halves the steps
    that sixteen lanes need that slide at different moments; and it holds more of the torque than a line does.
    """
    z = max(-1.0, min(1.0, memory + BRISTLE_DAMPING * change))
    return z * (1.5 - 0.5 * z * z)
