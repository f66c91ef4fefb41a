"""Read untrusted YAML, and keep the line of every key for messages."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from synth.errors import Problem, UserError
from synth.files.paths import read_bytes

SIZE_LIMIT = 1_000_000  # bytes; real projects have a few kilobytes
NODE_LIMIT = 20_000  # keys and values, an alias counted at each use
DEPTH_LIMIT = 30  # nested levels; no format has more than eight

Key = tuple[str | int, ...]

# The C parser is ten times faster; its pure Python twin reads the same files where libyaml is absent.
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[+-]?\d{1,18}")
_FLOAT = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")
_TAG = "tag:yaml.org,2002:"
MERGE = f"{_TAG}merge"  # of the plain key <<


@dataclass(frozen=True)
class Document:
    """A YAML mapping with the 1-based line of each key path, list items by index."""

    path: Path
    name: str  # the file as the user named it
    value: dict[str, Any]
    lines: dict[Key, int]
    data: bytes

    def line(self, key: Key) -> int | None:
        """The line of a key path, or of its nearest written parent."""
        for end in range(len(key), 0, -1):
            if key[:end] in self.lines:
                return self.lines[key[:end]]
        return None

    def problem(self, text: str, key: Key = ()) -> Problem:
        """A mistake at a key path of this file."""
        return Problem(text, self.name, self.line(key), dotted(key, self.value) or None)


def load(path: str | Path) -> Document:
    """Read one YAML mapping.

    Raises
    ------
    UserError
        If the file cannot be read, is too large or too deep, is not a mapping, or has a syntax error, a
        duplicate key, or a tag for anything but plain data.
    """
    path = Path(path)
    name = str(path)
    data = read_bytes(path, SIZE_LIMIT, "a project or leg file has a few kilobytes")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise UserError(Problem("is not UTF-8 text; save it as UTF-8", name, line)) from None
    root = _compose(text, name)
    if not isinstance(root, yaml.MappingNode):
        raise UserError(Problem('is not a list of "key: value" lines, which must begin with "kind: ..."', name, 1))
    builder = _Builder(name)
    value = builder.build(root, (), 0)
    if builder.problems:
        raise UserError(builder.problems)
    return Document(path, name, value, builder.lines, data)


def dotted(key: Key, value: Any) -> str:
    """A key path in words: ``joints.knee.link.mass``; an unnamed item by its number, ``trials[3]``."""
    text = ""
    for part in key:
        if isinstance(part, int):
            item = value[part] if isinstance(value, list) and part < len(value) else None
            label = item.get("name") if isinstance(item, dict) else None
            text += f".{label}" if isinstance(label, str) and label else f"[{part + 1}]"
            value = item
        else:
            shown = part if len(part) <= 60 else part[:57] + "..."
            text += f".{shown}" if text else shown
            value = value.get(part) if isinstance(value, dict) else None
    return text


def _compose(text: str, name: str) -> yaml.Node | None:
    """Parse to nodes. Events are counted first, because nodes are built by recursion."""
    try:
        depth = 0
        for count, event in enumerate(yaml.parse(text, Loader=_Loader), start=1):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if count > NODE_LIMIT or depth > DEPTH_LIMIT:
                limit = f"more than {NODE_LIMIT} values" if count > NODE_LIMIT else f"more than {DEPTH_LIMIT} levels"
                line = event.start_mark.line + 1 if event.start_mark else None
                raise UserError(Problem(f"has {limit}, which no project needs", name, line))
        return yaml.compose(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        context = f" {error.context}" if error.context else ""
        found = f"is not valid YAML: {error.problem or 'it cannot be read'}{context}{_hint(text, error)}"
        raise UserError(Problem(found, name, mark.line + 1 if mark else None)) from None
    except yaml.YAMLError as error:
        place = getattr(error, "position", None)
        line = text[:place].count("\n") + 1 if isinstance(place, int) else None
        raise UserError(Problem(f"is not valid YAML: {error}".splitlines()[0], name, line)) from None


def _hint(text: str, error: yaml.MarkedYAMLError) -> str:
    mark = error.problem_mark
    lines = text.splitlines()
    if mark is not None and mark.line < len(lines) and "\t" in lines[mark.line][: mark.column + 1]:
        return "; indent with spaces, not tabs"
    if mark is not None and mark.line < len(lines) and re.search(r":\s*[%@`]", lines[mark.line]):
        return "; put a value that begins with such a sign in quotes"
    if "flow sequence" in str(error.context) and mark is not None and mark.line < len(lines):
        bracketed = re.search(r"[^\s,\[\]{}\"']+\[[^\],]*\][^\s,\[\]{}\"']*", lines[mark.line])
        if bracketed is not None:
            return f'; put a name with brackets in quotes: "{bracketed[0]}"'
    if "alias" in str(error.context):
        return "; put a name that begins with * in quotes"
    return ""


class _Builder:
    """Converts nodes to plain data, noting lines and collecting mistakes."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.lines: dict[Key, int] = {}
        self.problems: list[Problem] = []
        self.count = 0

    def build(self, node: yaml.Node, key: Key, depth: int) -> Any:
        self.count += 1
        if self.count > NODE_LIMIT or depth > DEPTH_LIMIT:
            # Only aliases lead here, because events were counted: exponential expansion, or an alias that
            # contains itself.
            line = node.start_mark.line + 1
            raise UserError(Problem("its aliases (*name) unfold to more than a project can hold", self.name, line))
        self.lines.setdefault(key, node.start_mark.line + 1)
        if not isinstance(node, yaml.ScalarNode) and node.tag not in (f"{_TAG}map", f"{_TAG}seq"):
            self._refuse_tag(node, key)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, key, depth)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(item, (*key, index), depth + 1) for index, item in enumerate(node.value)]
        return self._scalar(node, key)

    def _mapping(self, node: yaml.MappingNode, key: Key, depth: int) -> dict[str, Any]:
        merging = [pair for pair in node.value if pair[0].tag == MERGE]
        result = self._merged(merging, key, depth)
        own: set[str] = set()
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            if key_node.tag == MERGE:
                continue
            if not isinstance(key_node, yaml.ScalarNode):
                self.problems.append(Problem("a key must be text", self.name, line, dotted(key, None) or None))
                continue
            child: Key = (*key, key_node.value)
            if key_node.value in own:
                text = f"is given twice (first in line {self.lines[child]}); keep one"
                self.problems.append(Problem(text, self.name, line, dotted(child, None)))
                continue
            own.add(key_node.value)
            self.lines[child] = line
            result[key_node.value] = self.build(value_node, child, depth + 1)
        return result

    def _merged(self, pairs: list[tuple[yaml.Node, yaml.Node]], key: Key, depth: int) -> dict[str, Any]:
        """The keys that ``<<: *name`` or ``<<: [*one, *two]`` take from other mappings; of several the first counts."""
        result: dict[str, Any] = {}
        for key_node, value_node in pairs:
            several = isinstance(value_node, yaml.SequenceNode)
            for source in reversed(value_node.value if several else [value_node]):
                if isinstance(source, yaml.MappingNode):
                    result |= self.build(source, key, depth + 1)
                    continue
                text = "takes over keys of another mapping: mark that with &name and write <<: *name"
                line = key_node.start_mark.line + 1
                self.problems.append(Problem(text, self.name, line, dotted((*key, "<<"), None)))
        return result

    def _scalar(self, node: yaml.Node, key: Key) -> Any:
        text: str = node.value
        tag = node.tag.removeprefix(_TAG)
        if tag == "null":
            return None
        if tag == "bool":
            return text.lower() in ("true", "yes", "on")
        if tag in ("int", "float") and _INTEGER.fullmatch(text):
            return int(text)
        if tag in ("int", "float") and _FLOAT.fullmatch(text) and math.isfinite(float(text)):
            return float(text)
        # Dates, sexagesimal, numbers beyond all doubles and other special ones are kept as text: our files have none.
        if tag not in ("str", "int", "float", "timestamp", "value", "merge"):
            self._refuse_tag(node, key)
        return text

    def _refuse_tag(self, node: yaml.Node, key: Key) -> None:
        text = f"the tag {node.tag!r} is not read; write a plain value"
        self.problems.append(Problem(text, self.name, node.start_mark.line + 1, dotted(key, None) or None))
