"""All tables of the thesis' reproduction as one result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import synth
from synth.validation.built_leg import table_8
from synth.validation.comparison_table import ComparisonTable
from synth.validation.rat_tables import fit_rat, table_1, table_2
from synth.validation.robot_tables import fit_target, table_3, table_4, table_a1
from synth.validation.thesis_dampers import table_6
from synth.validation.thesis_data import LabData
from synth.validation.unseen_releases import unseen_table

FORMAT = "synth/reproduction/1"
Stage = Callable[[str], AbstractContextManager[object]]


def reproduce(data: LabData, *, seed: int = 0, stage: Stage | None = None) -> tuple[ComparisonTable, ...]:
    """Tables 1, 2, 3, 4, 6, 8 and A-1, and a table of unseen releases, from the laboratory's recordings.

    Parameters
    ----------
    seed : of the swarms.
    stage : gives a context manager for a stage with this description, e.g. a progress display.

    Raises
    ------
    UserError : a recording is missing or cannot be used.
    """
    step = stage or (lambda text: nullcontext())
    with step("the rat: the thesis' method, its mistakes, least squares"):
        rat = fit_rat(data, seed)
        tables = [table_1(data, rat), table_2(data, rat)]
    with step("the rat's other releases"):
        unseen = unseen_table(data)
        tables += [] if unseen is None else [unseen]
    with step("the robot leg: the same at half speed"):
        target = fit_target(data, seed)
        tables += [table_3(data, target), table_4(data, target)]
    with step("the dampers' drops"):
        tables.append(table_6(data, target.recordings))
    with step("the built leg, joint by joint"):
        tables.append(table_8(data))
    return (*tables, table_a1(data, target))


def reproduction_json(
    name: str, inputs: Mapping[str, str], tables: tuple[ComparisonTable, ...], seed: int
) -> dict[str, Any]:
    """The content of ``reproduction.json``."""
    return {
        "format": FORMAT,
        "name": name,
        "versions": {"synth": synth.__version__},
        "seed": seed,
        "tables": [table.as_json() for table in tables],
        "inputs": dict(inputs),
    }
