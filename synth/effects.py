"""Imports for a user's own effect file: the definition of an effect and the compiled building blocks.

A stable name for files outside this package (``--effect mine.py``, ``synth.load_effect`` and the entry point group
``synth.effects``); the effects themselves live with their plant, in ``synth.swing.effects`` and ``synth.jump.effects``.
"""

from __future__ import annotations

from synth.swing.effects import Effect, Parameter, Prior, Shape
from synth.swing.effects.definition import size
from synth.swing.effects.inlined import bristle, held, inlined, power

__all__ = ["Effect", "Parameter", "Prior", "Shape", "bristle", "held", "inlined", "power", "size"]
