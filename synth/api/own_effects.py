"""``synth.load_effect``: an effect of the user's own, known to every later call."""

from __future__ import annotations

from pathlib import Path

from synth.api.beside_project import require_path
from synth.swing.effects import Effect
from synth.swing.effects.users_own import load_file


def load_effect(file: str | Path) -> Effect:
    """Execute a Python file that holds an ``EFFECT``; every later call knows this effect.

    Files and legs made in code may then hold it by its name, and ``gap`` looks for it at every joint, as with the
    commands' option ``--effect``. Loading a file again after a change replaces its effect.

    Parameters
    ----------
    file
        written as "Your own effect, part, format" of the documentation says.

    Raises
    ------
    UserError
        If the file is missing or fails, holds no valid effect, or another effect has its name.
    """
    require_path(file, 'load_effect("cubic_drag.py")')
    return load_file(file)
