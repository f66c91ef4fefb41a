"""Pages of the jumping leg: a study, the models compared with published results, and the gap of recorded jumps."""

from __future__ import annotations

from pathlib import Path

from synth.reports.openings.gap_opening import gap_opening
from synth.reports.openings.hopper_opening import study_opening, truth_opening
from synth.reports.page import SCRIPTS, write_page
from synth.reports.reading import read_result
from synth.reports.section import ReportSection
from synth.reports.sections import (
    files,
    gap_evidence,
    gap_how_far,
    gap_next,
    gap_terms,
    gap_which,
    hopper_choice,
    hopper_gap,
    hopper_jump,
    hopper_models,
    hopper_parts,
    hopper_truth,
    inputs,
    live_jump,
)
from synth.reports.sections.hopper_equations import SECTION as EQUATIONS
from synth.reports.sections.live_leg import block

STUDY_SECTIONS: tuple[ReportSection, ...] = (
    hopper_choice.MAP,
    hopper_choice.SECTION,
    hopper_jump.SECTION,
    hopper_models.SECTION,
    hopper_parts.SECTION,
    inputs.SECTION,
    files.SECTION,
    EQUATIONS,
)
TRUTH_SECTIONS: tuple[ReportSection, ...] = (
    hopper_truth.SECTION,
    hopper_truth.HEIGHTS,
    hopper_truth.MAPS,
    hopper_truth.SENSITIVITIES,
    EQUATIONS,
)
GAP_SECTIONS: tuple[ReportSection, ...] = (
    gap_which.OF_A_JUMP,
    gap_evidence.SECTION,
    gap_how_far.SECTION,
    hopper_gap.WHERE,
    hopper_gap.ACROSS,
    gap_next.SECTION,
    gap_terms.OF_A_JUMP,
    inputs.SECTION,
)


def write_hopper_report(folder: Path) -> Path:
    """Write ``report.html`` from ``hopper.json`` and the files beside it.

    Raises
    ------
    ReportError
        If ``hopper.json`` is missing or not a study of a jumping leg, or a file that it names is damaged.
    """
    result = read_result(folder, "hopper.json", "hopper")
    jump, designs = live_jump.jump_data(result), live_jump.designs_data(result)
    blocks = [block(name, data) for name, data in (("jump-data", jump), ("designs-data", designs)) if data is not None]
    return write_page(result, "Jumping leg", STUDY_SECTIONS, study_opening(result), (*SCRIPTS, "jump.js"), blocks)


def write_truth_report(folder: Path) -> Path:
    """Write ``report.html`` from ``truth.json``."""
    result = read_result(folder, "truth.json", "hopper-truth")
    return write_page(result, "Models and measurement", TRUTH_SECTIONS, truth_opening(result))


def write_jump_gap_report(folder: Path) -> Path:
    """Write ``report.html`` from a jumping leg's ``gap.json``, ``predicted/*.csv`` and ``where/*.csv``."""
    result = read_result(folder, "gap.json", "gap")
    return write_page(result, "Gap between model and measured jumps", GAP_SECTIONS, gap_opening(result))
