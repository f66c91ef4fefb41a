"""The result of a check of recordings, and its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.check.channels import Channel
from synth.diagnosis.check.clocks import Sampling
from synth.diagnosis.check.coverage import Coverage
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.check.lags import Lag
from synth.diagnosis.check.separability import InseparableCauses, VisibleCause

FORMAT = "synth/gap-check/1"


@dataclass(frozen=True)
class Check:
    """Whether a project's recordings can be used, warnings, and the causes they can distinguish.

    ``sines`` : see ``Separability``. ``remainder`` : share of each joint's motion (RMS) assumed to remain
    unexplained, in addition to the noise, in ``showings`` and ``clusters``.
    """

    name: str
    trials: int
    findings: tuple[Finding, ...]
    recordings: tuple[Sampling, ...]
    channels: tuple[Channel, ...]
    coverage: tuple[Coverage, ...]
    lags: tuple[Lag, ...]
    showings: tuple[VisibleCause, ...]
    clusters: tuple[InseparableCauses, ...]
    sines: Array
    remainder: float
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def usable(self) -> bool:
        """Whether there is no fault."""
        return all(finding.level != "fault" for finding in self.findings)

    @property
    def sentence(self) -> str:
        """The answer."""
        faults = sum(finding.level == "fault" for finding in self.findings)
        doubts = sum(finding.level == "doubt" for finding in self.findings)
        shown = sum(bool(showing.visible_from) for showing in self.showings)
        count = f"{self.trials} recording{'s' if self.trials != 1 else ''}"
        if faults:
            return f"{count}: {_count_text(faults, 'fault')} to correct first; a diagnosis would be wrong."
        begun = f"{count} can be used" + (f", with {_count_text(doubts, 'doubt')}" if doubts else "")
        open_ = f" {_count_text(len(self.clusters), 'group')} of them cannot be separated." if self.clusters else ""
        return f"{begun}. They could show {shown} of {len(self.showings)} causes.{open_}"

    def as_json(self) -> dict[str, Any]:
        """``check.json``."""
        return {
            "format": FORMAT,
            "name": self.name,
            "sentence": self.sentence,
            "usable": self.usable,
            "findings": [finding.as_json() for finding in self.findings],
            "recordings": [one.as_json() for one in self.recordings],
            "channels": [one.as_json() for one in self.channels],
            "coverage": [one.as_json() for one in self.coverage],
            "lags": [one.as_json() for one in self.lags],
            "remainder_assumed": self.remainder,
            "causes": [one.as_json() for one in self.showings],
            "not_told_apart": [one.as_json() for one in self.clusters],
            "sines": np.round(self.sines, 3).tolist(),
            "inputs": dict(self.inputs),
        }


def _count_text(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' if count != 1 else ''}"
