"""``make pages`` finds the browser's helpers from where it stands, before it computes anything."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "pages.py"
IMPORTED = """import pathlib, runpy, sys
sys.path[0] = {folder!r}
runpy.run_path({tool!r})["opening_times"](pathlib.Path({results!r}))
"""


def test_the_table_of_opening_times_can_be_written(tmp_path: Path) -> None:
    code = IMPORTED.format(folder=str(TOOL.parent), tool=str(TOOL), results=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
