"""The input: files, settings, defaults, versions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.quantities import text
from synth.reports.reading import Result, unit_of, value_of
from synth.reports.section import ReportSection, fit_key, fit_of, mapping, sequence

MOST_FILES = 14  # input files shown unfolded


def content(result: Result) -> dict[str, Any]:
    """Inputs with hashes, settings, defaults and versions."""
    document = result.content
    listed = document.get("inputs")
    if isinstance(listed, Mapping):  # fit.json: file -> sha256
        listed = [{"file": name, "sha256": value} for name, value in listed.items()]
    files = [item for item in listed or [] if isinstance(item, Mapping)]
    settings = [_setting(key, value) for key, value in mapping(document, "settings").items()]
    fit = fit_of(result)
    settings += [
        {"key": f"{fit_key(result)}{key}", "value": str(fit[key]), "how": how}
        for key, how in (
            ("method", "estimation method"),
            ("cost", "minimised cost"),
            ("iterations", "steps until it stopped"),
            ("reason", "why it stopped"),
            ("lost_samples", "samples left out as lost"),
        )
        if fit.get(key) is not None
    ]
    return {
        "inputs": files,
        "many": len(files) > MOST_FILES,
        "settings": settings,
        "defaults": [item for item in sequence(document, "defaults") if isinstance(item, Mapping)],
        "versions": mapping(document, "versions"),
    }


def _setting(key: str, value: Any) -> dict[str, str]:
    if isinstance(value, Mapping):
        shown = text(value) if value_of(value) is not None else str(value.get("value", "–"))
        if unit_of(value) == "1" and key == "time_scale":
            shown = f"× {shown}"
        return {"key": f"settings.{key}", "value": shown, "how": str(value.get("how") or "")}
    if isinstance(value, list):
        return {"key": f"settings.{key}", "value": ", ".join(map(str, value)), "how": ""}
    return {"key": f"settings.{key}", "value": "–" if value is None else str(value), "how": ""}


SECTION = ReportSection("inputs", "Input", content)
