"""The legs of bought springs in their drawn joints: whether they reach through their caps, and what is cut off them."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from synth.design.choose_springs import SpringOption
from synth.remarks import decisive

if TYPE_CHECKING:
    from synth.cad import JointDimensions

CALLIPER = 0.05  # mm: what is shorter by less is not told from the drawn length
REMEDY = "Name a spring with longer legs, or have one wound (make: true)."


def drawn_arm(joint: JointDimensions) -> tuple[float, float]:
    """Length (mm) of an arm as drawn, and up to which its cap clamps it, both along the wire from the coil."""
    from synth.cad.checked_layout import lay_out

    layout = lay_out(joint)
    along = hypot(1.0, layout.upper.slope)
    return layout.arm_length, (layout.free_arm + layout.seat.length) * along


def short_legs(name: str, option: SpringOption, joint: JointDimensions) -> list[str]:
    """A decisive sentence for each part whose legs, by the catalogue, end before the far end of their caps."""
    _, needed = drawn_arm(joint)
    found = []
    for row in (option.row, option.mirror):
        if row is None or row.leg_length is None or row.leg_length * 1e3 >= needed - CALLIPER:
            continue
        text = (
            f"{name}: the legs of {row.part} are {row.leg_length * 1e3:.4g} mm long, but their caps clamp them up to "
            f"{needed:.1f} mm from the coil"
        )
        found.append(decisive(text, REMEDY))
    return found


def cut_words(leg_length: float | None, joint: JointDimensions | None) -> str:
    """What to cut a bought spring's legs (m, None: unknown) to, for the bill; empty where nothing is cut or drawn."""
    if joint is None:
        return ""
    whole, _ = drawn_arm(joint)
    if leg_length is None:
        return f", legs cut to {whole:.1f} mm from the coil"
    return f", legs of {leg_length * 1e3:.4g} mm cut to {whole:.1f} mm" if leg_length * 1e3 > whole + CALLIPER else ""
