"""A spring that acts in one direction only, or with two rates."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Shape, signed


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, loss_above, loss_below
):
    """Take back the share of the spring's torque that one side lacks."""
    return spring_rate * (loss_above * max(deflection, 0.0) + loss_below * min(deflection, 0.0)), 0.0


def to_rotation(sign: int, zero: float, loss_above: float, loss_below: float) -> tuple[float, float]:
    """Above and below are meant in measured angle."""
    return (loss_above, loss_below) if sign > 0 else (loss_below, loss_above)


EFFECT = Effect(
    name="one_sided_spring",
    meaning="a spring that acts in one direction only, or with two rates",
    formula="spring torque times (1 - loss) on one side of the free angle",
    source="bilinear stiffness: Shaw & Holmes, J. Sound and Vibration 90 (1983) 129",
    way="torque",
    belongs_to="spring",
    linear=True,
    parameters=(
        Parameter("loss_above", "1", 0.0, signed(0.6, 1.0), natural=False, meaning="share lost above the free angle"),
        Parameter("loss_below", "1", 0.0, signed(0.6, 1.0), natural=False, meaning="share lost below the free angle"),
    ),
    strengths=("loss_above", "loss_below"),
    shapes=(Shape(("loss_above",), {}), Shape(("loss_below",), {})),
)
