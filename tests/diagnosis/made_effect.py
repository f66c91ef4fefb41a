"""The user-written effect of the documentation; its strength in N m/(rad/s)^3."""

from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
CUBIC_DRAG = (DOCS / "examples" / "effects" / "cubic_drag.py").read_text(encoding="utf-8")
