"""A spring that acts in one direction only, or with two rates."""

from __future__ import annotations

from math import sqrt

from synth.swing.effects.definition import Effect, Parameter, Shape, signed, size
from synth.swing.effects.inlined import inlined


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
    loss_above,
    loss_below,
    shift,
    width,
):
    """Subtract the share of the spring's torque that one side lacks, with a smooth changeover between the sides."""
    beyond = deflection - shift
    root = sqrt(beyond * beyond + width * width)
    return 0.5 * spring_rate * (loss_above * (beyond + root - width) + loss_below * (beyond - root + width)), 0.0


def to_rotation(
    sign: int, zero: float, loss_above: float, loss_below: float, shift: float
) -> tuple[float, float, float]:
    """Convert above and below from measured angle."""
    return (loss_above, loss_below, shift) if sign > 0 else (loss_below, loss_above, -shift)


EFFECT = Effect(
    name="one_sided_spring",
    meaning="a spring that acts in one direction only, or with two rates",
    phrase="has a spring with two rates",
    needs=("spring",),
    formula="rate k (1 - loss) on one side of the free angle + shift; the changeover rounded over width",
    source="bilinear stiffness: Shaw & Holmes, J. Sound and Vibration 90 (1983) 129",
    way="torque",
    belongs_to="spring",
    parameters=(
        Parameter(
            "loss_above",
            "1",
            0.0,
            signed(0.6, 1.0),
            natural=False,
            meaning="share lost above the free angle",
            form="share",
        ),
        Parameter(
            "loss_below",
            "1",
            0.0,
            signed(0.6, 1.0),
            natural=False,
            meaning="share lost below the free angle",
            form="share",
        ),
        Parameter(
            "shift", "rad", 0.0, signed(0.02), natural=False, meaning="distance of the changeover from the free angle"
        ),
        Parameter("width", "rad", 0.0, size(0.03), natural=False, meaning="width of the changeover"),
    ),
    strengths=("loss_above", "loss_below"),
    shapes=(Shape(("loss_above", "shift", "width"), {}), Shape(("loss_below", "shift", "width"), {})),
)
