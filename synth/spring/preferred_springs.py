"""Preferences among springs that keep their limits: design life, and enough coils. A dropped one is stated."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import DESIGN_LIFE, FEWEST_COILS, SpringDesign
from synth.spring.spring_search import describe, lasts, worst_excess
from synth.spring.unit_text import UnitText, join_texts


def prefer_springs(
    good: list[SpringDesign], found: Callable[[], Iterable[SpringDesign]], wish: SpringRequirements
) -> tuple[list[SpringDesign], tuple[str, ...]]:
    """Of the springs that keep the limits, those that last; of these, those with ``FEWEST_COILS`` coils or more.

    A preference that no spring meets is dropped, and a note gives the reason. ``found`` gives all candidates.
    """
    notes: list[str] = []
    lasting = [design for design in good if lasts(design, wish.limits)]
    if not lasting and good[0].life is None:
        notes.append(f"no fatigue data are known for {good[0].material} wire: no design life can be checked")
    elif not lasting:
        notes.append(
            f"no spring within the limits lasts {DESIGN_LIFE:.0f} full turns; this one only bears the static load"
        )
    good = lasting or good
    many = [design for design in good if design.body_coils >= FEWEST_COILS]
    if many or wish.limits.max_coils < FEWEST_COILS:
        return many or good, tuple(notes)
    stiff = [d for d in found() if d.body_coils >= FEWEST_COILS and (not lasting or lasts(d, wish.limits))]
    nearest = min(stiff, key=worst_excess, default=None)
    why = (
        "no stock wire gives the rate with an allowed spring index"
        if nearest is None
        else UnitText(
            "the nearest (", describe(nearest), ") has ", join_texts("; ", (v.text for v in nearest.violations))
        )
    )
    return good, (*notes, UnitText(f"fewer than {FEWEST_COILS:.0f} coils, because with more coils ", why))
