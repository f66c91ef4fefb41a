"""What the diagnoses of swinging and of jumping legs have in common."""

from __future__ import annotations

from abc import abstractmethod

from synth.api.report import Cell, Report
from synth.diagnosis.diagnosis_result import Diagnosis, RankedCause


class Diagnosed(Report):
    """Verdict, causes and warnings of a diagnosis, as a sentence and as a table."""

    @property
    @abstractmethod
    def diagnosis(self) -> Diagnosis:
        """The diagnosis."""

    @property
    def verdict(self) -> str:
        """``effect``, ``none``, ``tie`` or ``unknown``."""
        return self.diagnosis.verdict

    @property
    def ranked(self) -> tuple[RankedCause, ...]:
        """Single causes, the most probable first."""
        return self.diagnosis.ranked

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the data."""
        return self.diagnosis.warnings

    @property
    def headline(self) -> str:
        """The verdict as a sentence."""
        return self.diagnosis.sentence

    def columns(self) -> dict[str, list[Cell]]:
        """One row per cause, then ``none`` and ``unknown``: probability, and the share of the gap it explains alone."""
        found = self.diagnosis
        shrinks = [item.shrink for item in found.ranked]
        return {
            "cause": [*(item.cause.effect for item in found.ranked), "none", "unknown"],
            "joint": [*(item.cause.joint for item in found.ranked), None, None],
            "probability": [
                *(item.probability for item in found.ranked),
                found.probability_none,
                found.probability_unknown,
            ],
            "shrink": [*(None if item is None else item.value for item in shrinks), None, None],
            "shrink low": [*(None if item is None else item.low for item in shrinks), None, None],
            "shrink high": [*(None if item is None else item.high for item in shrinks), None, None],
        }
