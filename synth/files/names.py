"""Rules for names in a user's file.

A joint's name becomes a column, a file and a part of a drawing: letters and digits of any alphabet, space, ``_``,
``.`` and ``-``. A title (of a leg, a project, a part) is only displayed: any printable character. Files that we
write are named by the first rule, whatever their recording is called.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

NAME_LENGTH = 60  # characters: a file name of it with a folder fits every system
TITLE_LENGTH = 200  # characters: two lines of a page's title
# \w: the letters and digits of every alphabet, and the underscore. The first character keeps out "..", hidden files,
# options and formulas; the last one keeps out what Windows drops from the end of a file's name.
_NAME = re.compile(r"\w(?:[\w .-]*[\w-])?")
_UNWRITTEN = re.compile(r"[^\w .-]")
# Control, format (bidirectional marks, zero width), surrogate, private and unassigned characters, line separators.
_UNPRINTED = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
# The words that a part's file has behind its joint's name.
_PARTS = frozenset((
    "upper", "lower", "shaft", "arm", "damper", "spring", "encoder", "link", "mount", "inside", "assembly", "print",
    "measured",
))  # fmt: skip
ALLOWED = 'letters, digits, space, "_", "." and "-", no space, "." or "-" in front, no space or "." behind'


def name_fault(name: str) -> str | None:
    """Why ``name`` cannot name a joint; None if it can."""
    if len(name) > NAME_LENGTH:
        return f"has {len(name)} characters; at most {NAME_LENGTH} are allowed"
    return None if _NAME.fullmatch(name) else f"is not allowed: write {ALLOWED}"


def title_fault(title: str) -> str | None:
    """Why ``title`` cannot name a leg, a project or a part; None if it can."""
    if not title.strip():
        return "is empty; write a name"
    if len(title) > TITLE_LENGTH:
        return f"has {len(title)} characters; at most {TITLE_LENGTH} are allowed"
    bad = unprinted(title)
    return None if bad is None else f"holds the character {bad}, which cannot be printed; write it without"


def file_name(name: str) -> str:
    """The name as it stands in file names: spaces become underscores."""
    return name.replace(" ", "_")


def written_name(name: str) -> str:
    """A recording's name as a result file's name: characters that no joint name allows become ``_``.

    ``walk (2)`` becomes ``walk _2_``. Only files that we write are renamed.
    """
    text = _UNWRITTEN.sub("_", name)[:NAME_LENGTH].rstrip(" .")
    return text if text[:1] not in ("", " ", ".", "-") else f"_{text[1:]}"


def same_file(names: Iterable[str], name: str) -> str | None:
    """The one of ``names`` that a file system may confuse with ``name``: it differs in case, or in a space."""
    folded = file_name(name).casefold()
    return next((known for known in names if file_name(known).casefold() == folded), None)


def mixed_files(names: Sequence[str]) -> str | None:
    """Why the drawings of joints with these names would collide; None if they would not.

    A joint's files are ``NAME.png`` and ``NAME_PART.step``, the whole leg's ``leg.png`` and ``leg_PART.step``.
    """
    folded = {name: file_name(name).casefold() for name in names}
    for name, text in folded.items():
        if text == "leg" or _is_part_of(text, "leg"):
            return f'the files of "{name}" would be called like those of the whole leg; rename the joint'
        other = next((known for known, start in folded.items() if _is_part_of(text, start)), None)
        if other is not None:
            return f'the files of "{name}" would be called like those of a part of "{other}"; rename one of the joints'
    return None


def _is_part_of(name: str, whole: str) -> bool:
    return name.startswith(f"{whole}_") and name.removeprefix(f"{whole}_").partition("_")[0] in _PARTS


def unprinted(text: str) -> str | None:
    """The first character of the text that cannot be printed, as ``U+0007``."""
    bad = next((sign for sign in text if unicodedata.category(sign) in _UNPRINTED), None)
    return None if bad is None else f"U+{ord(bad):04X}"
