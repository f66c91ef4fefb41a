"""A joint without a spring or damper: intervals from 0, the same in table, JSON, page and sentences."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import bare
from fit.test_any_speed import pendulum, swings
from page_reader import Page
from synth.cli import main
from synth.files.tolerance import Tolerance
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg, Spring

NO_SPRING = pendulum(1e-9, 0.02).with_joints(knee={"spring": Spring(1e-9, 0.0)})
TIMES, STARTS = np.arange(0.0, 3.0, 0.01), np.array([[20.0], [-35.0]])
LEG = """kind: leg
name: pendulum
joints:
  - {name: knee, zero: 0 deg, sign: +1, link: {length: 300 mm, mass: 0.4 kg, com: 120 mm, inertia: 3e-3 kg*m^2}}
"""


def fit(nominal: Leg, **widths: float) -> FitResult:
    """The fit of swings without a spring, believed to be those of ``nominal``."""
    made = recordings(bare(nominal), swings(NO_SPRING, TIMES, STARTS))
    return fit_leg(bare(nominal), made, LegFitOptions(tolerance=Tolerance(**widths) if widths else None))


def test_table_json_page_and_sentences_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "leg.leg.yaml").write_text(LEG)
    for k, trial in enumerate(swings(NO_SPRING, TIMES, STARTS)):
        rows = np.column_stack([trial.time, np.degrees(trial.angles)])
        np.savetxt(tmp_path / f"t{k}.csv", rows, "%.6f", ",", header="time [s],knee [deg]", comments="")
    (tmp_path / "fit.yaml").write_text("kind: fit\nleg: leg.leg.yaml\ntrials: [t*.csv]\n")
    assert main(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "out")]) == 0
    screen, found = capsys.readouterr().out, json.loads((tmp_path / "out" / "fit.json").read_text())
    spring, free = found["joints"]["knee"]["spring_rate"], found["joints"]["knee"]["free_angle"]
    least, most = spring["interval90"]
    assert least == 0.0
    assert spring["value"] < most < 0.03  # N m/rad: 5 % of the weight's, by tolerances of 1 and 2 %
    low, high = free["interval90"]  # numbers, as the format says: anywhere the search may put it
    assert low < free["value"] - 360.0
    assert free["value"] + 360.0 < high
    row = next(line.split() for line in screen.splitlines() if line.startswith("knee "))
    assert float(row[2]) == 0.0
    assert float(row[4]) == pytest.approx(most, abs=6e-5)
    told = f"do not tell the spring rate from none: it is at most some {most:.2g} N*m/rad. Its free angle is unknown."
    words = re.sub(r"\s+", " ", "".join(Page((tmp_path / "out" / "report.html").read_text()).words))
    for text in (screen, words.replace("\u00b7", "*").replace("\u00a0", " "), " ".join(found["not_separable"])):
        assert told in text
        assert "free angle is known only" not in text
    sources = {each["quantity"]: each for each in found["interval_sources"]}
    assert set(sources) == {"spring_rate", "damper_rate"}
    assert sources["spring_rate"]["half_width90"]["value"] == pytest.approx(0.5 * most)
    assert f"spring rate's upper limit of {most:.2g} N*m/rad comes from" in sources["spring_rate"]["text"]
    assert found["proposals"] == []  # of a spring that is not there a pose tells nothing


def test_the_limit_is_that_of_links_that_are_off() -> None:
    """A link whose mass is nearer than believed looks like a spring; the interval's deviation is that spring."""
    knee = NO_SPRING.joints[0]
    farther = replace(NO_SPRING, joints=(replace(knee, link=replace(knee.link, com=1.02 * knee.link.com)),))
    right = fit(NO_SPRING, length=0.0, mass=0.0, com=0.02, inertia=0.0).joints["knee"].spring_rate
    off = fit(farther).joints["knee"].spring_rate
    assert right.high is not None
    assert (right.high - right.value) / 1.645 == pytest.approx(off.value, rel=0.25)


def test_the_limit_and_the_draws_without_tolerances_are_linear_too() -> None:
    result = fit(NO_SPRING)
    spring = result.joints["knee"].spring_rate
    assert spring.low == 0.0
    assert spring.high is not None
    assert any(f"at most some {spring.high:.2g} N*m/rad" in text for text in result.not_separable)
    drawn = [leg.joints[0].spring.rate for leg in result.drawn if leg.joints[0].spring is not None]
    assert max(drawn) < 3.0 * spring.high
