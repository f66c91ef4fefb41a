"""``--effect``: the user's own effects, known while a command runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from synth.errors import UserError
from synth.files.gap_kind import is_hopper_gap
from synth.files.yaml_lines import load
from synth.swing.foreign_effects import known_effects


@contextmanager
def own_effects(files: Sequence[str], project: str | None) -> Iterator[None]:
    """Within the block these files' effects are known; they are executed, unless the ``project`` has no use for them.

    Raises
    ------
    UserError : the project is of a jumping leg, a file holds no valid effect, or its code fails within the block.
    """
    if project is not None and _jumps(project):
        raise UserError("--effect applies to swinging legs; a jumping leg has built-in effects only")
    with known_effects(files):
        yield


def _jumps(project: str) -> bool:
    """Whether a project is of a jumping leg; one that cannot be read is left to the command."""
    if Path(project).suffix.casefold() not in (".yaml", ".yml"):
        return False
    with suppress(UserError):
        kind = str(load(project).value.get("kind"))
        return kind.startswith("hopper") or (kind == "gap" and is_hopper_gap(project))
    return False
