"""Links, assumed masses, and seat settings for measured springs on the page."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from page_reader import page_of
from synth.reports import write_leg_report
from synth.reports.reading import Result
from synth.reports.section import AbsentResult
from synth.reports.sections import links

LegFolder = Callable[..., tuple[Path, dict[str, Any]]]


def test_links_are_listed_as_assumed_as_drawn_and_as_simulated(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    name = next(iter(design["joints"]))
    setting = {"turn": (4.0, "deg"), "left": (0.0, "deg"), "rate": (15.0, "N*m/rad"), "free_angle": (98.0, "deg")}
    design["joints"][name]["seat"] = {"setting": {key: {"value": v, "unit": u} for key, (v, u) in setting.items()}}
    (folder / "design.json").write_text(json.dumps(design))
    _, page = page_of(write_leg_report(folder))
    text = " ".join(page.text.replace("\xa0", " ").split())
    assert "assumed 200 g" in text
    assert "simulated 400 g" in text
    assert "agree after 2 rounds" in text
    assert "Assumed masses: a_damper 54 g" in text
    assert "Seats for the measured springs" in text
    assert "15 N·m/rad 98°" in text


def test_without_solids_it_is_left_out(tmp_path: Path) -> None:
    assert isinstance(links.content(Result(tmp_path, "design.json", {"links": {}})), AbsentResult)
