"""How an effect's torque is compiled: inlined into the lane loop, where branch-free code becomes vector code."""

from __future__ import annotations

from typing import Any

from numba import njit

inlined: Any = njit(inline="always", fastmath=True, error_model="numpy")

BRISTLE_DAMPING = 0.004  # s
SPRING_BACK = 500.0  # 1/s, how fast a bristle that a step bent too far comes back to sliding


@inlined
def bristle(rate, memory, presliding):  # type: ignore[no-untyped-def]
    """Rate of change of a bristle's bend (memory, -1..1 while it holds): bent by motion, until it slides.

    Elastic, then perfectly plastic (Prandtl's element): nothing stiff happens while the joint slides, as it does in
    Dahl's smooth law, whose bend settles with ``rate / presliding``, ten thousand times a second.
    """
    bend = abs(memory)
    sliding = (bend >= 1.0) & (rate * memory > 0.0)
    settle = -SPRING_BACK * (memory - max(-1.0, min(1.0, memory)))
    return settle if sliding else rate / presliding


@inlined
def held(memory, change):  # type: ignore[no-untyped-def]
    """Share of the friction torque that a bristle's bend and its rate of change give, at most one.

    The rate damps what would otherwise ring on while the joint sticks; cut off at one, it turns the torque over at
    once when the joint turns back, as dry friction does.
    """
    return max(-1.0, min(1.0, memory + BRISTLE_DAMPING * change))
