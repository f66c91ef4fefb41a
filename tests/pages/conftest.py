"""Result folders to open in a browser, and the browser."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from pages.browser import chromium, missing
from tool_modules import loaded

WRITTEN = ("report.html", "winding_sheet.html")


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium; skips, saying so, where there is none."""
    if why := missing():
        pytest.skip(f"pages are not opened in a browser: {why}")
    with chromium() as found:
        yield found


@pytest.fixture(scope="session")
def made() -> ModuleType:
    """The makers of result folders that the pages' other tests use."""
    return loaded("made_results", Path(__file__).parents[1] / "reports" / "conftest.py")


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory, made: ModuleType) -> dict[str, Path]:
    """Pages by name: those of ``PAGES_FROM``, which ``make pages`` fills with every command's results, or made ones."""
    given = os.environ.get("PAGES_FROM")
    if given:
        folders = sorted(path for path in Path(given).iterdir() if path.is_dir())
        return {folder.name: folder / name for folder in folders for name in WRITTEN if (folder / name).is_file()}
    from diagnosis.made_result import made_result
    from synth.diagnosis.plants.swinging_chain.chain_write import write_gap
    from synth.files.gap_project import GapProject, Tolerance
    from synth.reports import write_fit_report, write_gap_report, write_leg_report

    root = tmp_path_factory.mktemp("pages")
    made.make_design(root / "leg", trials=3)
    made.make_fit(root / "fit", ["hip", "knee"], 3)
    (root / "gap").mkdir()
    result = made_result()
    write_gap(result, GapProject(Path("gap.yaml"), "robot", result.leg, (), Tolerance(), 0, (), ()), root / "gap")
    return {
        "leg": write_leg_report(root / "leg"),
        "fit": write_fit_report(root / "fit"),
        "gap": write_gap_report(root / "gap"),
    }
