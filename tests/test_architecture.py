"""The picture of the packages is drawn from the imports as they are, and each package stands in the text."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def architecture() -> ModuleType:
    return tool("architecture")


def test_the_picture_shows_the_imports(architecture: ModuleType) -> None:
    graph = architecture.packages(architecture.imports(architecture.modules()))
    assert architecture.cycles(graph) == []
    drawn = architecture.PICTURE.read_text(encoding="utf-8")
    assert drawn == architecture.draw(graph), "run: make architecture"


def test_every_package_is_described(architecture: ModuleType) -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    graph = architecture.packages(architecture.imports(architecture.modules()))
    missing = [name for name in graph if name != "synth" and f"`{name}`" not in text and f"| {name} |" not in text]
    assert missing == []


def test_a_circle_is_found(architecture: ModuleType) -> None:
    assert architecture.cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    assert architecture.cycles({"a": {"b"}, "b": set()}) == []
