"""Read back the JSON results that this program wrote."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError
from synth.files.paths import read_bytes

SIZE_LIMIT = 200_000_000  # bytes; a gap of hundreds of trials has a few megabytes

# kind -> the version of its format that this program writes.
FORMATS = {"fit": 1, "gap": 1, "rehearsal": 1, "leg-design": 1, "spring": 1, "hopper": 1, "reproduction": 1}
_FORMAT = re.compile(r"synth/([a-z-]+)/([1-9]\d{0,3})")


def read_fit(path: str | Path) -> dict[str, Any]:
    """Read a ``fit.json``; see ``read_result``."""
    return read_result(path, "fit", ("joints", "rms", "trials"))


def read_design(path: str | Path) -> dict[str, Any]:
    """Read a ``design.json``; see ``read_result``."""
    return read_result(path, "leg-design", ("stages", "joints", "response", "files"))


def read_result(path: str | Path, kind: str, keys: tuple[str, ...] = ()) -> dict[str, Any]:
    """Read a result of one kind.

    Parameters
    ----------
    path
        the JSON file.
    kind
        what it must be: ``fit``, ``leg-design``, ...
    keys
        required keys besides ``format``.

    Raises
    ------
    UserError
        If it is not JSON, of another kind or a newer version, lacks a key, or contains a number that is not finite.
    """
    name = str(path)
    data = read_bytes(Path(path), SIZE_LIMIT, "no result is so large")

    def constant(text: str) -> float:
        raise UserError(Problem(f"contains {text}, which is not a JSON number", name))

    try:
        result = json.loads(data.decode("utf-8-sig"), parse_constant=constant)
    except UnicodeDecodeError:
        raise UserError(Problem("is not UTF-8 text", name)) from None
    except json.JSONDecodeError as error:
        raise UserError(Problem(f"is not valid JSON: {error.msg}", name, error.lineno)) from None
    except (RecursionError, ValueError):
        raise UserError(Problem("is not a result of this program: too deep, or a number too long", name)) from None
    if not isinstance(result, dict):
        raise UserError(Problem("is not a result of this program: the format is missing", name))
    _check_format(result.get("format"), kind, name)
    missing = [Problem("is missing", name, key=key) for key in keys if key not in result]
    if missing:
        raise UserError(missing)
    return result


def _check_format(found: object, kind: str, name: str) -> None:
    match = _FORMAT.fullmatch(found) if isinstance(found, str) else None
    if match is None or match.group(1) not in FORMATS:
        wanted = f"synth/{kind}/{FORMATS[kind]}"
        raise UserError(Problem(f'is not a result of this program: its format is {found!r}, not "{wanted}"', name))
    if match.group(1) != kind:
        raise UserError(Problem(f"is a result of kind {match.group(1)} where {kind} is needed", name, key="format"))
    if int(match.group(2)) > FORMATS[kind]:
        text = f"has version {match.group(2)} of its format; this program reads up to {FORMATS[kind]}: update it"
        raise UserError(Problem(text, name, key="format"))
