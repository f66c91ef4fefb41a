"""What all tests have in common."""

from __future__ import annotations

import csv
import gc
import os
from pathlib import Path

import pytest

from synth.threads import LIBRARIES

# As every command does before numpy is loaded: threads of the linear algebra only wait for each other here.
for name in LIBRARIES:
    os.environ.setdefault(name, "1")

TESTS = Path(__file__).resolve().parent

gc.disable()  # while hundreds of modules are imported there is nothing to collect: a fifth of that time


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest modules first: none is then left to one process at the end (``tools/long_modules.py``)."""
    with (TESTS / "long_modules.csv").open(encoding="utf-8", newline="") as file:
        seconds = {TESTS.parent / row["module"]: float(row["seconds"]) for row in csv.DictReader(file)}
    items.sort(key=lambda item: -seconds.get(item.path, 0.0))  # in a module the order stays


def pytest_collection_finish() -> None:
    """All tests are imported."""
    gc.enable()
