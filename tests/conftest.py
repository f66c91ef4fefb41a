"""What all tests have in common."""

from __future__ import annotations

import csv
import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from synth.threads import LIBRARIES, VARIABLE

# As every command does before numpy is loaded: threads of the linear algebra only wait for each other here.
for name in LIBRARIES:
    os.environ.setdefault(name, "1")
# Each core has its own process of tests: threads of one would only take turns with the other. Tests about threads set
# their number themselves.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault(VARIABLE, "1")

TESTS = Path(__file__).resolve().parent


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """While hundreds of modules are imported there is no garbage to look for, which took a fifth of that time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest modules first: none is then left to one process at the end (``tools/long_modules.py``)."""
    with (TESTS / "long_modules.csv").open(encoding="utf-8", newline="") as file:
        seconds = {TESTS.parent / row["module"]: float(row["seconds"]) for row in csv.DictReader(file)}
    items.sort(key=lambda item: -seconds.get(item.path, 0.0))  # in a module the order stays
