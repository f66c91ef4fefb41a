"""Record how long the modules of tests take: ``tests/long_modules.csv``, from the last ``make test``.

``make test`` writes ``build/tests.xml``; ``python tools/long_modules.py`` adds up its times. ``tests/conftest.py`` lets
the longest modules run first, so that none is left to one process at the end while the other has nothing to do.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tests" / "long_modules.csv"
SHORTEST = 3.0  # s: shorter modules fill what is left, in any order


def module_times(report: Path) -> dict[str, float]:
    """Module of tests -> s, set-up and clearing included, of pytest's JUnit report."""
    times: Counter[str] = Counter()
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        parts = case.attrib["classname"].split(".")
        while len(parts) > 1 and not (ROOT / "/".join(parts)).with_suffix(".py").is_file():
            parts.pop()  # a class of the module
        times["/".join(parts) + ".py"] += float(case.attrib["time"])
    return dict(times)


def table(times: dict[str, float]) -> str:
    """The table's text, the longest module first."""
    long = sorted((-seconds, name) for name, seconds in times.items() if seconds >= SHORTEST)
    return "module,seconds\n" + "".join(f"{name},{-seconds:.0f}\n" for seconds, name in long)


if __name__ == "__main__":
    TABLE.write_text(table(module_times(ROOT / "build" / "tests.xml")), encoding="utf-8")
    sys.stdout.write(f"{TABLE.relative_to(ROOT)} written\n")
