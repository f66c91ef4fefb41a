"""One link on one spring without gravity, of inertia ``INERTIA`` about its joint: where closed forms are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

Array = NDArray[np.float64]

LINK = Link(0.2, 0.5, 0.1, 5e-3)
INERTIA = LINK.inertia + LINK.mass * LINK.com**2  # 0.01 kg m^2
RATE = 4.0  # N m/rad: 20 rad/s
OMEGA = 20.0
Effects = Mapping[str, Mapping[str, float]]


def leg(
    effects: Effects,
    *,
    rate: float | None = RATE,
    damper: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    free_angle: float = 0.0,
    gravity: float = 0.0,
) -> Leg:
    """The joint with these effects; ``rate`` None for no spring."""
    spring = None if rate is None else Spring(rate, free_angle)
    held = None if damper is None else Damper(damper)
    return Leg("one", (Joint("joint", LINK, zero, sign, None, spring, held, effects),), gravity=gravity)


def swing(made: Leg, start: float, rate: float, times: Sequence[float] | Array, tolerance: float = 1e-9) -> Array:
    """(n_time, 2) rotation and rate."""
    return simulate(made, [start], [rate], np.asarray(times, dtype=float), tolerance=tolerance, rates=True)
