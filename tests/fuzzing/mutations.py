"""Common faults of files and command lines: changes of YAML, of tables, of the files themselves, and of flags."""

from __future__ import annotations

import math
import os
import random
from collections.abc import Callable
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import yaml

LONG = "x" * 5000
MOST_ROWS = 100_000
MOST_PLACES = 10_000  # of a file's values; one that an earlier change made a bomb of aliases has 2**30
NASTY: tuple[Any, ...] = (
    None, True, 0, -1, 1e308, -1e-308, math.nan, math.inf, 10**30, "", " ", "nan", "nan kg", "inf m", "-3 mm", "0 mm",
    "1e-300 kg", "1e300 m", "1e9 deg", "5", "5 %", "-5 %", "500 %", "3 parsec", "12 N*m/rad", "1 deg", "2 s",
    "-2 s", "1e-12 kg*m^2",
    "1e12 kg", "9" * 50, LONG, "../../etc/passwd", "/etc/passwd", "~/x", "*", "**", "trials/*", "[", "a\x1bb",
    "a\nb", "a/b",
    "é\u0301", "\u202eabc", "=1+1", "<script>", "{}", [], [[]], {}, {"a": 1}, ["1 m", "2 m"], [1, 2, 3], {"file": "x"},
    "auto",
    "common", "per_trial", "hip", "knee", "Hip", "base", "all", "none", "yes", "2020-01-01", "0x10", "1:30",
         "C:\\x", "con",
    ".",
    "..", "-", "--out",
)  # fmt: skip
CELLS = ("", "nan", "inf", "-inf", "abc", "1e308", "-1e308", "1e-320", "0", "1_000", "0x1", "1,5", '"', "'", "=1", "#",
         " ",
         "9" * 400, "1e999", "0e400", "²", "٣", "\u2028", "\x1c", "\\ud800", "é", "\t1", "-0")  # fmt: skip
UNITS = ("deg", "rad", "s", "ms", "us", "N*m", "mm", "V", "", "furlong", "1", "%", "deg/s", "min", "h", "kg", "°", "[")
NAMES = (
    "x y.csv",
    "-a.csv",
    "a\nb.csv",
    "é.csv",
    "a;b.csv",
    "x" * 200 + ".csv",
    "a.b.csv",
    " .csv",
    "CON.csv",
    "a.csv.yaml",
)


def change(generator: random.Random, folder: Path, command: list[str], names: list[str]) -> str:
    """Change one thing of a project that lies in ``folder``, or of its command line; returns what."""
    kinds: list[tuple[int, Callable[[], str]]] = [(2, lambda: flag(generator, command))]
    projects = [name for name in names if name.endswith((".yaml", ".yml"))]
    tables = [name for name in names if name.endswith((".csv", ".mot"))]
    foreign = [name for name in names if name.endswith((".mot", ".trc", ".json"))]
    if projects:
        kinds += [(6, lambda: structure(generator, folder / generator.choice(projects)))]
        kinds += [(2, lambda: text(generator, folder / generator.choice(projects)))]
    if tables:
        kinds += [(5, lambda: cells(generator, folder / generator.choice(tables)))]
        kinds += [(1, lambda: text(generator, folder / generator.choice(tables)))]
    if foreign:
        kinds += [(8, lambda: words(generator, folder / generator.choice(foreign)))]
    if names:
        kinds += [(2, lambda: place(generator, folder, generator.choice(names)))]
    return generator.choices([kind for _, kind in kinds], [weight for weight, _ in kinds])[0]()


def structure(generator: random.Random, path: Path) -> str:
    """Change a value or a key of a YAML file."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        return "left as it is"
    places = list(islice(_places(content, ()), MOST_PLACES))
    if not places:
        return "left as it is"
    where = generator.choice(places)
    parent: Any = content
    for key in where[:-1]:
        parent = parent[key]
    last, kind = where[-1], generator.randrange(7)
    value = generator.choice(NASTY)
    if kind <= 2:
        parent[last] = value
    elif kind == 3 and isinstance(parent[last], str) and " " in parent[last]:
        parent[last] = _scaled(generator, parent[last])
        value = parent[last]
    elif kind == 4:
        del parent[last]
        value = "deleted"
    elif kind == 5 and isinstance(parent, dict):
        name = str(last) + generator.choice(["", "s", " ", "_2", "\u200b"])
        parent[name] = parent.pop(last)
        value = f"renamed to {name!r}"
    elif kind == 6 and isinstance(parent, dict):
        parent[generator.choice(["extra", "name", "kind", "trials", "seed", str(last).upper()])] = value
    else:
        other = generator.choice(places)
        holder: Any = content
        for key in other[:-1]:
            holder = holder[key]
        if where[: len(other)] != other and other[: len(where)] != where:
            parent[last], holder[other[-1]] = holder[other[-1]], parent[last]
        value = f"exchanged with {other}"
    path.write_text(yaml.safe_dump(content, allow_unicode=True, sort_keys=False, width=1000), encoding="utf-8")
    return f"{path.name}: {where}: {str(value)[:60]!r}"


def _places(content: Any, above: tuple[Any, ...]) -> Any:
    """Every place of nested mappings and lists."""
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for key, value in items:
        yield (*above, key)
        yield from _places(value, (*above, key))


def _scaled(generator: random.Random, quantity: str) -> str:
    """A quantity much larger or smaller, or of the other sign."""
    number, _, unit = quantity.partition(" ")
    try:
        value = float(number)
    except ValueError:
        return quantity + " "
    factor = generator.choice([1e-9, 1e-6, 1e-3, 0.1, 10.0, 1e3, 1e6, 1e9, -1.0, 0.0])
    return f"{value * factor:g} {unit}"


def text(generator: random.Random, path: Path) -> str:
    """Damage a file as text or bytes."""
    data = bytearray(path.read_bytes())
    at = generator.randrange(len(data) + 1)
    kind = generator.choice([
        "cut", "flip", "zero", "utf16", "latin", "bom", "cr", "crlf", "tab", "twice", "tag", "bomb", "empty", "comment",
        "semicolons", "quote", "merge", "two documents",
    ])  # fmt: skip
    if kind == "cut":
        del data[at:]
    elif kind == "flip":
        if not data:  # an empty file has nothing to flip
            return f"{path.name}: empty"
        data[at % len(data)] ^= 1 << generator.randrange(8)
    elif kind == "zero":
        data[at:at] = b"\0"
    elif kind == "utf16":
        data = bytearray(bytes(data).decode("utf-8", "replace").encode("utf-16"))
    elif kind == "latin":
        data[at:at] = b"\xe9"
    elif kind == "bom":
        data[:0] = b"\xef\xbb\xbf"
    elif kind in ("cr", "crlf"):
        data = bytearray(bytes(data).replace(b"\n", b"\r" if kind == "cr" else b"\r\n"))
    elif kind == "twice":
        data = data + data
    elif kind == "empty":
        data = bytearray()
    elif kind == "semicolons":
        data = bytearray(bytes(data).replace(b",", b";"))
    elif kind == "bomb":
        data += b"\nb0: &b0 [x, x]\n" + b"".join(
            b"b%d: &b%d [*b%d, *b%d]\n" % (k, k, k - 1, k - 1) for k in range(1, 30)
        )
    else:
        added = {"tab": b"\t", "tag": b"!!python/object/apply:os.system ['touch pwned']", "comment": b"# x\n",
                 "quote": b'"',
                 "merge": b"\n<<: *x\n", "two documents": b"\n---\na: 1\n"}  # fmt: skip
        data[at:at] = added[kind]
    path.write_bytes(data)
    return f"{path.name}: {kind}"


def words(generator: random.Random, path: Path) -> str:
    """Put odd cells in place of some characters, half of them in the header."""
    content = path.read_text(encoding="utf-8", errors="replace")
    changes = []
    for _ in range(generator.randint(1, 4)):
        at = generator.randrange(min(len(content), generator.choice([500, len(content)])) + 1)
        odd = generator.choice(CELLS)
        content = content[:at] + odd + content[at + generator.choice([0, 1, 1, 2, 5]) :]
        changes.append(f"{odd[:20]!r} at {at}")
    path.write_text(content, encoding="utf-8")
    return f"{path.name}: {', '.join(changes)}"


def cells(generator: random.Random, path: Path) -> str:
    """Change a table: a cell, a row, a column, its header, its clock, its size."""
    rows = [line.split(",") for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]
    if len(rows) < 2 or len(rows[-1]) < 2:
        return "left as it is"
    kind = generator.choice([
        "cell", "cell", "row", "column", "unit", "name", "swap", "clock", "scale", "constant", "few", "back", "repeat",
        "holes",
        "many", "wide", "zeros", "noise", "step",
    ])  # fmt: skip
    width = len(rows[0])
    column, row = generator.randrange(width), generator.randrange(1, len(rows))
    row = row if len(rows[row]) == width else len(rows) - 1
    factor = generator.choice([1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e12, -1.0])
    body = range(1, len(rows))
    if kind == "cell":
        for _ in range(generator.choice([1, 1, 30])):
            line = rows[generator.randrange(1, len(rows))]
            line[column % len(line)] = generator.choice(CELLS)
    elif kind == "row":
        generator.choice([rows[row].append, lambda _: rows[row].pop()])("1")
    elif kind == "column":
        rows = [[cell for k, cell in enumerate(line) if k != column] for line in rows]
    elif kind == "unit":
        rows[0][column] = rows[0][column].partition("[")[0] + f"[{generator.choice(UNITS)}]"
    elif kind == "name":
        rows[0][column] = generator.choice(
            ["", "time [s]", "x [deg]", LONG, rows[0][column].upper(), "hip [deg]", "é [deg]"]
        )
    elif kind == "swap":
        other = generator.randrange(width)
        for k in body:
            if len(rows[k]) == width:
                rows[k][column], rows[k][other] = rows[k][other], rows[k][column]
    elif kind in ("clock", "scale"):
        rows = [rows[0], *(_times(line, 0 if kind == "clock" else column, factor) for line in rows[1:])]
    elif kind in ("constant", "zeros", "holes", "noise", "step"):
        for k in body:
            if column < len(rows[k]):
                first = rows[1][column % len(rows[1])]
                made = {"zeros": "0", "constant": first, "holes": "" if k % 3 else rows[k][column],
                        "noise": f"{generator.gauss(0.0, 50.0):.4f}", "step": "10" if k % 2 else "100"}  # fmt: skip
                rows[k][column] = made[kind]
    elif kind == "few":
        rows = rows[: generator.randrange(1, 12)]
    elif kind == "back":
        rows = [rows[0], *rows[:0:-1]]
    elif kind == "repeat":
        rows.insert(row, list(rows[row]))
    elif kind == "many":
        times = min(generator.choice([50, 400]), max(MOST_ROWS // len(rows), 1))
        rows = [rows[0], *_dense(rows[1:], times)]
    else:
        rows = [line + ["1"] * 300 for line in rows]
    path.write_text("\n".join(",".join(line) for line in rows) + "\n", encoding="utf-8")
    return f"{path.name}: {kind} column {column} row {row} factor {factor:g}"


def _times(line: list[str], column: int, factor: float) -> list[str]:
    try:
        return [f"{float(cell) * factor:.9g}" if k == column else cell for k, cell in enumerate(line)]
    except ValueError:
        return line


def _dense(rows: list[list[str]], times: int) -> list[list[str]]:
    """So many times as many rows, between the given ones."""
    found = []
    for first, second in pairwise(rows):
        for k in range(times):
            try:
                mixed = [
                    f"{float(a) + (float(b) - float(a)) * k / times:.9g}" for a, b in zip(first, second, strict=True)
                ]
            except ValueError:
                mixed = first
            found.append(mixed)
    return [*found, rows[-1]]


def place(generator: random.Random, folder: Path, name: str) -> str:
    """Put something else where a file was."""
    path = folder / name
    if not path.is_file():
        return "left as it is"
    kind = generator.choice(
        ["gone", "folder", "pipe", "dangling", "loop", "device", "outside", "renamed", "big", "empty", "bytes"]
    )
    data = path.read_bytes()
    path.unlink()
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind in ("dangling", "loop", "device"):
        path.symlink_to({"dangling": "nowhere", "loop": path.name, "device": "/dev/zero"}[kind])
    elif kind == "outside":
        (folder.parent / "outside" / "file").write_bytes(data)
        path.symlink_to(folder.parent / "outside" / "file")
    elif kind == "renamed":
        path.with_name(generator.choice(NAMES)).write_bytes(data)
    elif kind == "bytes":
        Path(os.fsdecode(os.fsencode(path.parent) + b"/b\xff" + os.fsencode(path.suffix))).write_bytes(data)
    elif kind == "big":
        with path.open("wb") as stream:
            stream.truncate(200_000_000)
    elif kind == "empty":
        path.write_bytes(b"")
    return f"{name}: {kind}"


def flag(generator: random.Random, command: list[str]) -> str:
    """Change one word of the command line."""
    value = str(generator.choice([item for item in NASTY if isinstance(item, (str, int, float))])).replace("\0", "")
    kind, at = generator.randrange(4), generator.randrange(1, len(command))
    if command[at].startswith("{out}") or command[at] == "--out":
        kind = 3
    if kind == 0:
        command[at] = value
    elif kind == 1:
        del command[at]
    elif kind == 2:
        command[at] = command[at][:-1]
    else:
        command.append(
            generator.choice(
                [value, "--frob", "--out=", "-q", "--dry-run", "--json", "--help", "--seed=-1", "--workers=0"]
            )
        )
    return f"command: {' '.join(command)[:200]}"
