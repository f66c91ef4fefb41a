"""The files of the design, with hashes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, sequence


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Paths, what each is, and SHA-256."""
    files = [dict(item) for item in sequence(result.content, "files") if isinstance(item, Mapping)]
    if not files:
        return AbsentResult("design.json lists no file")
    for item in files:
        item["here"] = result.path(str(item.get("path"))) is not None
    return {"files": files}


SECTION = ReportSection("files", "Files", content)
