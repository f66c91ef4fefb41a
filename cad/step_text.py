"""A STEP file's text without parts that change between runs, so that the same solids give the same bytes.

Four parts of the kernel's output (OCCT 7.9) change: the time in the header; the numbers of the assembly links (a
counter of the whole process); the order of the colours, which follows addresses in memory; and zeros, which are written
as 0 or 1e-16 depending on the order in which surfaces were intersected, also by addresses.
"""

from __future__ import annotations

import re
from contextlib import suppress

TIMESTAMP = "2000-01-01T00:00:00"  # in every header instead of the clock
_STATEMENT = re.compile(r"#(\d+) = (.*?);\n", re.DOTALL)
_SMALL = re.compile(r"E-(?:1[2-9]|[2-9]\d)(?![\d.])")  # the exponent of a number below 1e-11
_STYLE = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION("
_ITS_NUMBER = re.compile(r"#(\d+) = ")
_STYLES = (
    "STYLED_ITEM('color',(#{0}),#{item})",
    "PRESENTATION_STYLE_ASSIGNMENT((#{1}))",
    "SURFACE_STYLE_USAGE(.BOTH.,#{2})",
    "SURFACE_SIDE_STYLE('',(#{3}))",
    "SURFACE_STYLE_FILL_AREA(#{4})",
    "FILL_AREA_STYLE('',(#{5}))",
    "FILL_AREA_STYLE_COLOUR('',#{6})",
)


def normalised_step(text: str) -> str:
    """The text of a STEP file with a fixed time stamp, links numbered from 1 and colours in the parts' order.

    Raises
    ------
    ValueError
        if the colours are not written in this kernel's form; otherwise the file could be wrong.
    """
    text = re.sub(r"(FILE_NAME\(\s*'[^']*'\s*,\s*)'[^']*'", rf"\g<1>'{TIMESTAMP}'", text, count=1)
    return _ordered_colours(_numbered_links(_encode_text(_without_rounding(text))))


def _without_rounding(text: str) -> str:
    """Numbers under 1e-12 as zero, without a sign; each statement on one line, whose breaks depend on the numbers.

    A search for the exponent, and for the line break itself, is ten times as fast as one for the number before it.
    """
    head, mark, data = text.partition("DATA;\n")
    data = re.sub(r"\n\s*", "", data.replace(";\n", "\0")).replace("\0", ";\n")
    pieces, last = [], 0
    for match in _SMALL.finditer(data):
        start = match.start()
        while data[start - 1] in "0123456789.-":
            start -= 1
        pieces += [data[last:start], "0."]
        last = match.end()
    data = "".join((*pieces, data[last:]))
    return head + mark + data.replace("-0.,", "0.,").replace("-0.)", "0.)")


def _encode_text(text: str) -> str:
    """Non-ASCII characters in the UTF-16 form of ISO 10303-21; the kernel treats each UTF-8 byte as a character."""
    if text.isascii():  # as nearly every file
        return text

    def encode(match: re.Match[str]) -> str:
        letters = match.group()
        with suppress(UnicodeError):
            letters = letters.encode("latin-1").decode("utf-8")
        return rf"\X2\{letters.encode('utf-16-be').hex().upper()}\X0" + "\\"

    return re.sub(r"[^\x00-\x7f]+", encode, text)


def _numbered_links(text: str) -> str:
    """Links numbered from 1; statements on single lines, because longer numbers change the line breaks."""
    number = 0

    def renumber(match: re.Match[str]) -> str:
        nonlocal number
        number += 1
        rest = re.sub(r"\n\s*", "", match.group(1))
        return f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}'{rest};"

    return re.sub(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\(\s*'[^']*'([^;]*);", renumber, text)


def _ordered_colours(text: str) -> str:
    """The closing block of colours, one set of statements a solid, in the order of the solids."""
    start, number = _first_style(text)
    if start < 0:
        return text
    end = text.index("ENDSEC;", start)
    statements = {int(number): re.sub(r"\n\s*", "", body) for number, body in _STATEMENT.findall(text[start:end])}
    groups = sorted(_colour_groups(statements))
    lines: list[str] = []
    for item, context, colour in groups:
        ids = range(number + 2, number + 2 + len(_STYLES))
        lines.append(
            f"#{number} = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#{number + 1}),#{context});"
        )
        for offset, style in enumerate(_STYLES):
            lines.append(f"#{number + 1 + offset} = {style.format(*ids, item=item)};")
        lines.append(f"#{ids[-1]} = {colour};")
        number = ids[-1] + 1
    return text[:start] + "\n".join(lines) + "\n" + text[end:]


def _first_style(text: str) -> tuple[int, int]:
    """Where the first statement of a style begins a line, and its number; -1: there is none.

    Found by its word, because a search for the beginnings of lines takes a fifth of all the time of this module.
    """
    place = text.find(_STYLE)
    while place >= 0:
        start = text.rfind("\n", 0, place) + 1
        if (number := _ITS_NUMBER.fullmatch(text, start, place)) is not None:
            return start, int(number.group(1))
        place = text.find(_STYLE, place + 1)
    return -1, 0


def _colour_groups(statements: dict[int, str]) -> list[tuple[int, int, str]]:
    """(solid, its context, colour) of each styled solid."""
    groups, used = [], 0
    for body in statements.values():
        head = re.fullmatch(r"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION\('',\(#(\d+)\),#(\d+)\)", body)
        if head is None:
            continue
        styled = re.fullmatch(r"STYLED_ITEM\('color',\(#(\d+)\),#(\d+)\)", statements.get(int(head.group(1)), ""))
        if styled is None:
            raise ValueError(f"unknown style in a STEP file: {statements.get(int(head.group(1)))!r}")
        body = statements[int(styled.group(1))]
        while not body.startswith(("COLOUR_RGB", "DRAUGHTING_PRE_DEFINED_COLOUR")):
            used += 1
            following = re.findall(r"#(\d+)", body)
            if len(following) != 1:
                raise ValueError(f"unknown style in a STEP file: {body!r}")
            body = statements[int(following[0])]
        groups.append((int(styled.group(2)), int(head.group(2)), body))
    colours = sum(body.startswith(("COLOUR_RGB", "DRAUGHTING_PRE")) for body in statements.values())
    if 2 * len(groups) + used + colours != len(statements):
        raise ValueError("a STEP file's closing block holds more than colours")
    return groups
