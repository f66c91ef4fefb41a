"""What to change where a spring to wind breaks a limit only as its drawn joint holds it: the key of that limit."""

from __future__ import annotations

from collections.abc import Iterable

from synth.files.project_options import CadOptions
from synth.spring.spring_task import SpringLimits

# The key of each limit that a project states, and which way to move it: the search then leaves that much room.
_STATED = {
    "outer_diameter": "less max_outer_diameter",
    "inside_diameter": "more min_inner_diameter",
    "least_outer_diameter": "more min_outer_diameter",
    "body_length": "less max_body_length",
    "least_body_length": "more min_body_length",
    "fatigue": "more cycles",
}


def remedy_of(joint: str, limits: Iterable[str], asked: SpringLimits, cad: CadOptions) -> str:
    """Sentences with what to change, for the names of broken ``limits`` (``Violation.limit``)."""
    found, keys = list[str](), f"select.joints.{joint}.spring"
    for limit in dict.fromkeys(limits):
        if limit == "arbor":
            shaft, room = (f"{value * 1e3:g} mm" for value in (cad.shaft_diameter, cad.clearance))
            required = asked.least_wound_inside() or 0.0
            found.append(
                f"The coil at full travel must leave {required * 1e3:.4g} mm for the shaft: make cad.shaft_diameter "
                f"({shaft}) or cad.clearance ({room}) somewhat smaller, or state min_inner_diameter under {keys}."
            )
        elif limit in _STATED:
            found.append(f"Ask for somewhat {_STATED[limit]} than you need under {keys}.")
        else:
            found.append(f"Ask for cycles, or for another wire or included_angle, under {keys}.")
    return " ".join(dict.fromkeys(found))
