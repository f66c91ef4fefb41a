"""The words that options of a fit take, without the schema: the command line shows them and must start quickly."""

from __future__ import annotations

from typing import Literal, get_args

FreeAngle = Literal["auto", "common", "per_trial"]
Method = Literal["least_squares", "piecewise", "swarm"]
Cost = Literal["trajectory", "transient", "characteristics"]
Weight = Literal["amplitude", "equal", "noise"]
Intervals = Literal["sensitivities", "bootstrap"]
Release = Literal["free", "recorded"]
Laws = Literal["auto", "linear"]


def allowed_values(option: str) -> tuple[str, ...]:
    """The words of ``method``, ``cost``, ``weight`` or ``intervals``."""
    return get_args({"method": Method, "cost": Cost, "weight": Weight, "intervals": Intervals}[option])
