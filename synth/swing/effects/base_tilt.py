"""The mount is not level."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, tilt: Array) -> None:
    """Rotate the base by ``tilt`` (n_lane,) rad, counter-clockwise."""
    legs.tilt += tilt


EFFECT = Effect(
    name="base_tilt",
    meaning="the mount is not level",
    phrase="is not level",
    formula="tilt of the leg + tilt",
    source="definition",
    way="leg",
    changes="`tilt` of the leg",
    where="base",
    parameters=(Parameter("tilt", "rad", prior=Prior(0.0, 0.08), natural=False, meaning="counter-clockwise"),),
    strengths=("tilt",),
    shapes=(Shape(("tilt",), {}),),
)
