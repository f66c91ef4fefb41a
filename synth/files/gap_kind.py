"""Whether a project of kind ``gap`` is about a swinging or a jumping leg; found without reading the whole project."""

from __future__ import annotations

from pathlib import Path

from synth.errors import UserError
from synth.files.paths import shared
from synth.files.yaml_lines import load


def is_hopper_gap(path: str | Path) -> bool:
    """Whether a project of kind ``gap`` names a jumping leg; an unreadable file is reported by the other reader."""
    return kind_of_leg(path) == "hopper-design"


def kind_of_leg(path: str | Path) -> str:
    """The kind of the file that a project of kind ``gap`` names as its leg; empty where it cannot be read."""
    try:
        document = load(path)
        name = document.value.get("leg")
        if document.value.get("kind") != "gap" or not isinstance(name, str):
            return ""
        return str(load(shared(document.path.parent, name)).value.get("kind"))
    except UserError:
        return ""
