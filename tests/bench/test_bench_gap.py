"""The bench of ``synth gap`` replaces functions of the diagnosis by timed ones: it has to follow their signatures."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.bench_gap import read, where_it_goes
from bench.gap_case import pendulum, write_project
from synth.diagnosis import screening, workbench


def test_the_bench_tells_where_a_diagnosis_spends_its_time_and_puts_everything_back(tmp_path: Path) -> None:
    project = read(write_project(pendulum(), 4, tmp_path / "pendulum"))
    before = screening.in_parallel, vars(workbench.Workbench).copy()
    rows = where_it_goes(project)
    assert (screening.in_parallel, vars(workbench.Workbench).copy()) == before
    assert sum(share for *_, share in rows) == pytest.approx(1.0)
    assert sum(share for name, _, _, share in rows if name.startswith("integrator")) > 0.1
    assert all(calls > 0 and seconds >= 0.0 for _, calls, seconds, _ in rows)
