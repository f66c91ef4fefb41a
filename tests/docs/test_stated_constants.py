"""Constants of the diagnosis stand in the pages as the code has them."""

from __future__ import annotations

from pathlib import Path

import pytest

from synth.diagnosis.cause_findings import LEAST_UNSEEN_SHARE
from synth.diagnosis.check.cause_responses import VISIBLE_SIGNAL
from synth.diagnosis.check.separability import ALIKE_SINE
from synth.diagnosis.odds import (
    CALIBRATED,
    FLOOR_RATIO,
    LEAST_FURTHER_SHARE,
    MOST_INDEPENDENT_A_TRIAL,
    MOST_INDEPENDENT_IN_ALL,
    REMAINDER_RATIO,
)
from synth.diagnosis.verdict import MOST_TIED

DOCS = Path(__file__).resolve().parents[2] / "docs"
WORDS = {0.1: "a tenth", 0.25: "a quarter", 7: "seven", 8.0: "eight", 20.0: "twenty"}


@pytest.mark.parametrize(
    ("page", "stated"),
    [
        ("theory.md", f"stays above {FLOOR_RATIO:g} to {REMAINDER_RATIO:g} times the noise"),
        ("theory.md", f"at most {WORDS[MOST_INDEPENDENT_A_TRIAL]}, or {WORDS[MOST_INDEPENDENT_IN_ALL]} in all trials"),
        ("theory.md", f"0.75/(1 + exp({CALIBRATED.steep:.0f} (s − {CALIBRATED.most:.2f})))"),
        ("theory.md", f"with {CALIBRATED.most_of_several:.2f} for the best set of several"),
        ("theory.md", f"a gap of more than {CALIBRATED.accuracy:.2%} of the motion's RMS".replace(".00%", " %")),
        ("theory.md", f"{WORDS[MOST_TIED + 1].capitalize()} or more explanations that are tied"),
        ("theory.md", f"takes less than {WORDS[LEAST_FURTHER_SHARE]} of the gap"),
        ("theory.md", f"takes less than {WORDS[LEAST_UNSEEN_SHARE]} of their gap"),
        ("theory.md", f"it shows from {VISIBLE_SIGNAL:g} on"),
        ("theory.md", f"under arcsin {ALIKE_SINE:g} ="),
        ("why_otherwise.md", f"{CALIBRATED.most_unknown / 2:.2f} at {CALIBRATED.most:.0%} and".replace("%", " %")),
        ("why_otherwise.md", f"with {CALIBRATED.most_of_several:.0%} in place of".replace("%", " %")),
        ("why_otherwise.md", f"must remove {WORDS[LEAST_FURTHER_SHARE]} of the gap"),
        ("measured.md", f"own accuracy up to {CALIBRATED.accuracy:.2%} of the motion".replace(".00%", " %")),
    ],
)
def test_a_page_states_the_constant_that_the_code_has(page: str, stated: str) -> None:
    text = " ".join((DOCS / page).read_text().split())
    assert stated in text
