"""The effect of the chosen parts on the motion: wanted against built, trial by trial."""

from __future__ import annotations

import math
from typing import Any

from synth.reports.figures.legend import legend
from synth.reports.figures.palette import BUILT, RECORDED, WANTED
from synth.reports.figures.trials import shared_limits, trial_figure
from synth.reports.quantities import number, unit_text
from synth.reports.reading import Json, Result
from synth.reports.response_files import Response, extremes, read_response
from synth.reports.section import AbsentResult, ReportSection, mapping

FOLDER = "responses/target"
_LINES = {"animal": RECORDED, "wanted": WANTED, "built": BUILT}


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Figures of the trials to show and errors by joint."""
    response = mapping(result.content, "response")
    files = result.files(FOLDER)
    if not files and not response:
        return AbsentResult(f"design.json has no response and there is no file in {FOLDER}")
    read = {file: found for file in files if (found := read_response(result, file)) is not None}
    shown = extremes(files, {file: _error(found) for file, found in read.items()})
    return {
        "figures": _figures([read[file] for file in shown]),
        "legend": legend([(RECORDED, "animal, scaled in time"), (WANTED, "wanted"), (BUILT, "built")]),
        "folder": FOLDER,
        "total": len(files),
        "shown": len(shown),
        "errors": mapping(response, "wanted_to_built"),
    }


def _error(response: Response) -> float:
    """The trial's largest RMS over joints between wanted and built."""
    found = [response.rms(joint, "wanted", "built") for joint in response.joints("wanted")]
    return max((value for value in found if value is not None), default=math.inf)


def _figures(responses: list[Response]) -> list[Json]:
    drawn = []
    for response in responses:
        panels = []
        for joint in response.joints("wanted"):
            rms = response.rms(joint, "wanted", "built")
            unit = unit_text(response.unit(joint, "wanted"))
            remark = "" if rms is None else f"rms {number(rms, 3, bare=False)}{unit}"
            if (panel := response.panel(joint, _LINES, remark)) is not None:
                panels.append(panel)
        if panels:
            drawn.append((response, panels))
    limits = shared_limits([panel for _, panels in drawn for panel in panels])
    return [
        {
            "trial": response.name,
            "svg": trial_figure(f"{response.name}: wanted and built angles", panels, limits, response.name),
        }
        for response, panels in drawn
    ]


SECTION = ReportSection("built", "Wanted against built response", content)
