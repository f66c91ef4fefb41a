"""The XML of a robot's file, which may come from anyone."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, XMLParser, fromstring

from synth.errors import Problem, UserError
from synth.files.paths import read_bytes


def root_element(path: Path, largest: int, why: str, *, write_out: str = "") -> Element:
    """The root of a file of at most ``largest`` bytes; ``why`` it is no larger, ``write_out``: who expands entities.

    Raises
    ------
    UserError
        If the file is too large, declares entities, or is not XML.
    """
    data = read_bytes(path, largest, why)
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:  # entities that name each other fill the memory
        advice = f"write it out without{f' ({write_out} does)' if write_out else ''}"
        raise UserError(Problem(f"declares entities, which are not read; {advice}", str(path)))
    try:
        return fromstring(data, XMLParser())
    except ParseError as error:
        raise UserError(Problem(f"is not XML: {error.msg}", str(path), line=error.position[0])) from None
