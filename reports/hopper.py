"""Pages of the jumping leg: the report of a study, and the page that holds the models against what was published."""

from __future__ import annotations

from pathlib import Path

from reports import page
from reports.reading import read_result
from reports.section import Section
from reports.sections import (
    files,
    hopper_choice,
    hopper_jump,
    hopper_models,
    hopper_parts,
    hopper_truth,
    inputs,
    warnings,
)
from reports.sections.hopper_equations import SECTION as EQUATIONS

STUDY_SECTIONS: tuple[Section, ...] = (
    warnings.SECTION,
    hopper_choice.SECTION,
    hopper_choice.MAP,
    hopper_models.SECTION,
    hopper_jump.SECTION,
    hopper_parts.SECTION,
    inputs.SECTION,
    files.SECTION,
    EQUATIONS,
)
TRUTH_SECTIONS: tuple[Section, ...] = (
    hopper_truth.SECTION,
    hopper_truth.HEIGHTS,
    hopper_truth.MAPS,
    hopper_truth.SENSITIVITIES,
    EQUATIONS,
)


def write_hopper_report(folder: Path) -> Path:
    """Write ``report.html`` from ``hopper.json`` and the files beside it.

    Raises
    ------
    ReportError
        If ``hopper.json`` is missing or no study of a jumping leg, or a file that it names is damaged.
    """
    return page._write(read_result(folder, "hopper.json", "hopper"), "Jumping leg", STUDY_SECTIONS)


def write_truth_report(folder: Path) -> Path:
    """Write ``report.html`` from ``truth.json``."""
    return page._write(read_result(folder, "truth.json", "hopper-truth"), "Models and measurement", TRUTH_SECTIONS)
