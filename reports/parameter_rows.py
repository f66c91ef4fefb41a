"""Parameters of a cause as people read them: a change with its sign and what comes of it, a share in per cent."""

from __future__ import annotations

from collections.abc import Mapping

from synth.reports.quantities import brief, interval_of, interval_text, text
from synth.reports.reading import Json, unit_of, value_of
from synth.reports.section import mapping

IN_PERCENT = ("share", "relative change")
SIGNED = ("change", "relative change")


def parameter_rows(cause: Mapping[str, object], document: Json) -> list[dict[str, str]]:
    """``name``, ``value``, ``interval`` and ``becomes`` of each parameter; of an older result by its own name."""
    shown = mapping(document, "effects", str(cause.get("effect")), "parameters")
    designed = mapping(document, "designed", str(cause.get("joint")))
    rows = []
    for name, quantity in mapping(cause, "parameters").items():
        row = _row(name, quantity, mapping(shown, name), designed)
        if name in mapping(cause, "gives"):
            row["becomes"] = _given(mapping(cause, "gives", name), mapping(cause, "stated").get(name))
        rows.append(row)
    return rows


def _row(name: str, quantity: object, shown: Json, designed: Json) -> dict[str, str]:
    name = str(shown.get("label") or name.replace("_", " "))
    choices, value = shown.get("choices"), value_of(quantity)
    if isinstance(choices, list) and value in range(len(choices)):
        return {"name": name, "value": str(choices[int(value or 0)]), "interval": "", "becomes": ""}
    form = shown.get("form")
    if form in IN_PERCENT and unit_of(quantity) == "1":
        quantity = _mapped(quantity, 100.0, 0.0, "percent")
    if unit_of(quantity) == "s" and abs(value_of(quantity) or 0.0) < 1.0:
        quantity = _mapped(quantity, 1000.0, 0.0, "ms")
    sign = "+" if form in SIGNED and (value_of(quantity) or 0.0) > 0.0 else ""
    return {
        "name": name,
        "value": sign + text(quantity),
        "interval": interval_text(quantity),
        "becomes": _becomes(quantity, designed.get(str(shown.get("added_to")))),
    }


def _given(quantity: object, stated: object) -> str:
    """``gives 15 ms for 5 ms stated``; ``gives 1.36 ohm`` where the leg file states none."""
    return f"gives {text(quantity)}" + ("" if value_of(stated) is None else f" for {brief(stated)} stated")


def _becomes(change: object, designed: object) -> str:
    """``gives 3.25 N·m/rad for 2.5 N·m/rad designed``; empty if the design has no such quantity."""
    value, unit = value_of(designed), unit_of(designed)
    if value is None or unit != unit_of(change):
        return ""
    return f"gives {text(_mapped(change, 1.0, value, unit))} for {brief(designed)} designed"


def _mapped(quantity: object, factor: float, offset: float, unit: str) -> Json:
    """Factor times the quantity and its interval, plus an offset."""

    def moved(value: float | None) -> float | None:
        return None if value is None else factor * value + offset

    found: Json = {"value": moved(value_of(quantity)), "unit": unit}
    interval = interval_of(quantity)
    return found if interval is None else {**found, "interval90": [moved(end) for end in interval]}
