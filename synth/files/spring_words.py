"""The words that options of a spring take, without the schema: the command line shows them and must start quickly."""

from __future__ import annotations

from typing import Literal

Objective = Literal["mass", "space", "life"]
RateFormula = Literal["64", "10.8"]  # as users write them; see ``synth.parts.coil_rate``
System = Literal["inch", "metric"]
Hand = Literal["right", "left"]
OTHER_HAND: dict[str, Hand] = {"right": "left", "left": "right"}
