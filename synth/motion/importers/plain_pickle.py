"""Lists, tuples, text and numbers from pickled data, without unpickling it.

PyTables stores the column names of a table pickled. Unpickling executes the file's instructions; here only the opcodes
of plain values are followed, and any other one is refused.
"""

from __future__ import annotations

import pickletools
from typing import Any

LARGEST_PICKLE = 5_000_000  # bytes; column names take kilobytes

_PUT = ("PUT", "BINPUT", "LONG_BINPUT", "MEMOIZE")
_GET = ("GET", "BINGET", "LONG_BINGET")
_VALUES = (
    "UNICODE", "BINUNICODE", "SHORT_BINUNICODE", "BINUNICODE8", "INT", "BININT", "BININT1", "BININT2", "LONG",
    "LONG1", "FLOAT", "BINFLOAT", "STRING", "BINSTRING", "SHORT_BINSTRING",
)  # fmt: skip
_CONSTANTS: dict[str, Any] = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False}
_MARK = object()


def plain_values(data: bytes) -> Any:
    """The value of pickled lists, tuples, text and numbers.

    Raises
    ------
    ValueError
        For anything else: an object, a call, damaged data.
    """
    if len(data) > LARGEST_PICKLE:
        raise ValueError("is too large")
    stack: list[Any] = []
    memo: dict[int, Any] = {}
    try:
        for opcode, argument, _ in pickletools.genops(data):
            name = opcode.name
            if name == "STOP":
                return stack.pop()
            if name in _PUT:
                memo[len(memo) if name == "MEMOIZE" else int(argument or 0)] = stack[-1]
            elif name in _GET:
                stack.append(memo[int(argument or 0)])
            elif name in _VALUES:
                stack.append(argument)
            elif name in _CONSTANTS:
                stack.append(_CONSTANTS[name])
            elif name not in ("PROTO", "FRAME"):
                _build(name, stack)
    except (IndexError, KeyError, TypeError) as error:
        raise ValueError(f"is damaged: {error}") from None
    raise ValueError("has no end")


def _build(name: str, stack: list[Any]) -> None:
    """Lists and tuples from what lies on the stack."""
    if name == "MARK":
        stack.append(_MARK)
    elif name in ("EMPTY_LIST", "EMPTY_TUPLE"):
        stack.append([] if name == "EMPTY_LIST" else ())
    elif name in ("LIST", "TUPLE", "APPENDS"):
        items: list[Any] = []
        while (item := stack.pop()) is not _MARK:
            items.append(item)
        items.reverse()
        if name == "APPENDS":
            stack[-1].extend(items)
        else:
            stack.append(items if name == "LIST" else tuple(items))
    elif name == "APPEND":
        last = stack.pop()
        stack[-1].append(last)
    elif name in ("TUPLE1", "TUPLE2", "TUPLE3"):
        count = int(name[-1])
        made = tuple(stack[-count:])
        del stack[-count:]
        stack.append(made)
    else:
        raise ValueError(f"holds more than lists, text and numbers ({name})")
