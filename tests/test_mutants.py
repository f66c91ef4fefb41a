"""The list of ``make mutants``: each text stands once in the sources, and the tests that it names are there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def mutants() -> ModuleType:
    return tool("mutants")


def test_every_mutant_applies_and_names_tests(mutants: ModuleType) -> None:
    assert len(mutants.MUTANTS) >= 30
    assert len({mutant.name for mutant in mutants.MUTANTS}) == len(mutants.MUTANTS)
    for mutant in mutants.MUTANTS:
        assert mutant.text != mutant.changed
        mutants.file_of(mutant)
        for place in mutant.tests.split():
            assert (ROOT / "tests" / place).exists(), f"{mutant.name}: {place}"


def test_a_text_that_is_gone_is_an_error(mutants: ModuleType) -> None:
    gone = mutants.Mutant("gone", "no line of the sources reads like this", "", "swing")
    with pytest.raises(ValueError, match="stands 0 times"):
        mutants.file_of(gone)


def test_a_mutant_that_no_test_looks_at_survives_and_one_that_is_tested_is_caught(
    mutants: ModuleType, tmp_path: Path
) -> None:
    """The runner itself: the shrink's root is seen by its tests and not by those of another room."""
    shrink = next(mutant for mutant in mutants.MUTANTS if mutant.name == "the shrink of squares")
    assert mutants.judge(shrink, tmp_path).caught
    elsewhere = replace(shrink, tests="motion/test_characteristics.py")
    assert not mutants.judge(elsewhere, tmp_path).caught
