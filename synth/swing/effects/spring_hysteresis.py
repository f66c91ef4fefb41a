"""Spring hysteresis: loading and unloading follow different curves, by internal slip or by relaxation.

The law has a kink where the motion reverses; at a tolerance of 1e-6 the error is within 5e-5 rad
(``tests/swing/effects``).
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive, size
from synth.swing.effects.inlined import inlined, power

NEVER = 1e9  # s, relaxation time of a spring that does not relax
LASTING = 1e6  # s, of a spring that is still loaded when the hand lets go: days, in any unit of time of the lanes
# Runge-Kutta steps of the loading before the release, and its length in slips: z is within 1e-3 slip there
LOADING_STEPS, LOADING = 12, 8.0


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation,
    rate,
    deflection,
    spring_rate,
    damper_rate,
    damper_torque,
    force,
    memory,
    stiffness,
    slip,
    relaxation,
    knee,
    unloading,
    settled,
):
    """A second spring whose deflection (memory, rad) is limited by slip and relaxes with time."""
    yielding = power(abs(memory / slip) + 1e-9, knee) * (1.0 if rate * memory > 0.0 else -unloading)
    return -stiffness * memory, rate * (1.0 - yielding) - memory / relaxation


def start(deflection, stiffness, slip, relaxation, knee, unloading, settled):  # type: ignore[no-untyped-def]
    """The second spring at the release: loaded by a slow motion from where it settled; unloaded if it relaxes.

    A hand moves the joint from its rest to where it is released and holds it there.
    """
    return np.where(relaxation >= LASTING, slip * loaded((deflection - settled) / slip, knee), 0.0)


def to_rotation(  # type: ignore[no-untyped-def]
    sign, zero, stiffness, slip, relaxation, knee, unloading, settled
):
    """Convert where it settled from the sense of the measured angle."""
    return stiffness, slip, relaxation, knee, unloading, sign * settled


def loaded(travel: Array, knee: Array) -> Array:
    """Deflection over the slip after loading by ``travel`` (in slips) from zero: dr/dx = 1 - r^knee.

    tanh(x) for a knee of 2, 1 - exp(-x) for 1; signed like the travel.
    """
    share, step = 0.0 * travel, np.minimum(np.abs(travel), LOADING) / LOADING_STEPS

    def slope(r: Array) -> Array:
        return 1.0 - np.minimum(r, 1.0) ** knee

    for _ in range(LOADING_STEPS):
        a = slope(share)
        b = slope(share + 0.5 * step * a)
        c = slope(share + 0.5 * step * b)
        share = share + step / 6.0 * (a + 2.0 * b + 2.0 * c + slope(share + step * c))
    return np.asarray(np.sign(travel) * np.clip(share, 0.0, 1.0))


EFFECT = Effect(
    name="spring_hysteresis",
    meaning="loading and unloading follow different curves",
    phrase="has a spring with hysteresis",
    needs=("spring",),
    formula="-stiffness z, dz/dt = w (1 - s |z / slip|^knee) - z / relaxation; s = 1 loading, -unloading else",
    source="slip: Wen, J. Eng. Mech. 102 (1976) 249, unloading = (beta - gamma)/(beta + gamma); Maxwell's element",
    way="torque",
    belongs_to="spring",
    linear=True,
    memory=True,
    parameters=(
        Parameter("stiffness", "N*m/rad", prior=size(0.3), meaning="rate of the part that slips or relaxes"),
        Parameter(
            "slip", "rad", NEVER, positive(0.3, 1.0, lower=0.06), off=NEVER, meaning="deflection at which it slips"
        ),
        Parameter("relaxation", "s", NEVER, positive(1.0, 1.5), off=NEVER, meaning="time constant of its relaxation"),
        Parameter(
            "knee",
            "1",
            1.5,
            positive(1.5, 0.5, 0.4, 6.0),
            off=1.5,
            natural=False,
            meaning="sharpness of the transition to slip",
            label="sharpness",
        ),
        Parameter(
            "unloading",
            "1",
            0.0,
            Prior(0.0, 0.5, lower=-1.0, upper=1.0),
            off=0.0,
            natural=False,
            meaning="how much stiffer than loading from zero it unloads",
        ),
        Parameter(
            "settled",
            "rad",
            0.0,
            Prior(0.0, 0.3),
            off=0.0,
            natural=False,
            anchor="settled",
            meaning="the spring's deflection, measured angle, at which the loop was unloaded before the release",
        ),
    ),
    strengths=("stiffness",),
    shapes=(
        Shape(("stiffness", "slip", "knee"), {"settled": 0.0}, ({"slip": 0.1}, {"slip": 0.5})),
        Shape(("stiffness", "relaxation"), {}, ({"relaxation": 0.3}, {"relaxation": 1.5}, {"relaxation": 8.0})),
    ),
)
