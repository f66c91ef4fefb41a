"""What a leg's forecast says of assumed damper laws."""

from __future__ import annotations

from synth.reports.opening import joined_names
from synth.reports.quantities import brief, number
from synth.reports.reading import Json, value_of
from synth.reports.section import mapping, sequence


def assumed_laws_words(forecast: Json) -> str:
    """On which assumed damper laws a forecast depends, and the error if they do not hold; empty if all are known."""
    laws = mapping(forecast, "assumed_laws")
    joints = [str(name) for name in sequence(laws, "joints")]
    if not joints:
        return ""
    many, within = len(joints) > 1, value_of(forecast.get("within"))
    least, most = brief(laws.get("least")), brief(laws.get("most"))
    beyond = within is not None and (value_of(laws.get("most")) or 0.0) > within
    return (
        f" This holds if the assumed damper law{'s' if many else ''} of {joined_names(joints)} "
        f"{'are' if many else 'is'} right; off by a factor of {number(value_of(laws.get('factor')))} at low speed, "
        f"nominal parts give {least} to {most}{', more than allowed' if beyond else ''}."
    )
