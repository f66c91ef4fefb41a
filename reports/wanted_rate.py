"""The spring rate that is wanted at a joint, and how far a spring is from it, the same in every table of a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.quantities import percent
from synth.reports.reading import value_of
from synth.reports.section import mapping


def wanted_rate(joint: Mapping[str, Any]) -> Any:
    """The quantity for which the joint's spring was sought; in older results the fitted rate."""
    sought = mapping(joint, "spring").get("wanted_rate")
    return sought or mapping(joint, "refit").get("spring_rate") or mapping(joint, "wanted").get("spring_rate")


def off_wanted(spring: Mapping[str, Any], wanted: object) -> str:
    """Difference of the rate of a joint's springs from the wanted one, in per cent: of bought springs as sold."""
    return percent(value_of(spring.get("rate_as_sold") or spring.get("rate")), value_of(wanted))
