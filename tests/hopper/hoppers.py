"""Legs and motors for the tests of the hopper."""

from __future__ import annotations

from functools import cache

from synth.hopper.motors import motor_of
from synth.jump.hopper_leg import Motor
from synth.parts.catalogs import Catalogue


@cache
def catalogue() -> Catalogue:
    return Catalogue.load()


def motor(ratio: int = 150, variant: str = "HP") -> Motor:
    """A micro metal motor at 6 V."""
    return motor_of(catalogue().find_motor(f"N20 {variant} 6V {ratio}:1"))
