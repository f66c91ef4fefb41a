"""The bill of materials: parts to order, wind, cut and print, with standard, size, length, vendor, quantity and mass.

The vendor column has only vendors: ``any`` for standard parts that every dealer sells, empty for parts to make. The
built-in catalogues have no prices; the price column, per piece, comes from the user's own table.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.design.leg_design import LegDesign
from synth.design.write_design import bought_or_wound
from synth.files.output import write_csv
from synth.spring.spring_result import WIRE_ALLOWANCE

HEADER = ("joint", "item", "how", "standard", "size", "length [mm]", "vendor", "part", "quantity", "price", "mass [g]",
          "print time [h]", "source")  # fmt: skip
BUY = "buy: "  # prefix of a drawn part that is a standard part to buy
_LISTED = ("spring", "damper")  # families that are listed as bought or wound already
SAW = 3.0  # mm of extra length of rods and tubes: saw cut and facing
# mm^3 of solid part an hour: PrusaSlicer 2.5.0 gave 3 h 4 min for 38.5 cm^3 of a clevis at its defaults (research of
# this project, 0.4 mm nozzle); a Markforged with fill as dense takes about as long.
PRINT_RATE = 38.5e3 / (3 + 4 / 60)
_STANDARD = re.compile(r"(?P<standard>(?:ISO|DIN|ASME) [\w.-]+(?: A)?) - (?P<what>.+)")
_SCREW = re.compile(r"(?P<size>M[0-9.]+) x (?P<length>[0-9.]+)")
_PIN = re.compile(r"(?P<size>[0-9.]+) x (?P<length>[0-9.]+) dowel")
_CUT = re.compile(r"cut from (?P<what>ground rod, h6|tube), (?P<size>[0-9. x]+) mm, (?P<length>[0-9.]+) mm long")
_WASHER = re.compile(r", with washer (?P<standard>ISO [0-9]+) - (?P<size>[0-9.]+)")


@dataclass(frozen=True)
class _Bought:
    """The data by which a standard part is ordered."""

    standard: str
    size: str
    length: str


def write_bom(design: LegDesign, parts: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write ``bom.csv``. ``parts``: the entries of ``solids.parts`` in ``design.json``, empty if nothing was drawn.

    Mass and print time are for the whole line.
    """
    rows = [_with_mass(_bought_line(row), parts) for row in bought_or_wound(design)]
    drawn = [part for part in parts if part["family"] not in _LISTED]
    rows += _merged([line for part in drawn for line in _lines(part)])
    rows += _inserts(drawn)
    if drawn:
        rows += _mount(design)
    order = {name: index for index, name in enumerate(design.built.joint_names)}
    rows.sort(key=lambda row: order[row["joint"]])
    write_csv(path, {name: [row[name] for row in rows] for name in HEADER})


def _row(joint: str, item: str, **cells: str) -> dict[str, str]:
    """A line; cells that are not given are empty."""
    return {**dict.fromkeys(HEADER, ""), "joint": joint, "item": item, "quantity": "1", "source": "drawn here", **cells}


def _bought_line(row: Mapping[str, str]) -> dict[str, str]:
    """A spring or damper as a line; a length of wire includes the allowance for winding."""
    wound = row["vendor"] == "to wind"
    cells = {**row, "how": "wind" if wound else "buy"}
    if wound:
        found = re.search(r"wire, (?P<size>[0-9.]+) mm, (?P<length>[0-9]+) mm a spring", row["item"])
        if found is not None:
            whole = float(found["length"]) + WIRE_ALLOWANCE * 1e3
            cells |= {"size": f"{found['size']} mm", "length [mm]": f"{whole:.0f}"}
            cells["item"] = f"{row['item']}; length with {WIRE_ALLOWANCE * 1e3:.0f} mm to hold and trim"
        cells["vendor"] = "any"
    return _row(row["joint"], **{key: value for key, value in cells.items() if key not in ("joint",)})


def _with_mass(row: dict[str, str], parts: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """A bought line with the mass of the drawn part; none for a damper, whose mass is not known from its envelope."""
    count = int(row["quantity"] or 1)
    wanted = "spring" if "spring" in row["item"] or "wire" in row["item"] else "damper"
    masses = [p["mass"] for p in parts if p["joint"] == row["joint"] and p["family"] == wanted and p["mass"]]
    hands = ", one of each hand" if wanted == "spring" and len(masses) == 2 else ""
    return {**row, "item": row["item"] + hands, "mass [g]": _grams(masses[0]["value"] * count) if masses else ""}


def _ordered(text: str) -> _Bought:
    """Standard, size and length of a standard part, parsed from the text of its drawn part."""
    found = _STANDARD.match(text)
    if found is None:
        return _Bought("", "", "")
    for pattern in (_SCREW, _PIN):
        sized = pattern.match(found["what"])
        if sized is not None:
            return _Bought(found["standard"], sized["size"], sized["length"])
    size = re.match(r"(M[0-9.]+|[0-9.]+ x [0-9.]+ x [0-9.]+|[0-9/]+-2Z|[0-9.]+)", found["what"])
    return _Bought(found["standard"], size[1] if size else "", "")


def _lines(part: Mapping[str, Any]) -> list[dict[str, str]]:
    """A drawn part's line, and that of the washer under a screw's head."""
    made, joint = str(part["made"]), str(part["joint"])
    mass = "" if part["mass"] is None else _grams(part["mass"]["value"])
    if made.startswith(BUY):
        text = made.removeprefix(BUY)
        washer = _WASHER.search(text)
        text = _WASHER.sub("", text).removesuffix("; with nut")
        ordered = _ordered(text)
        lines = [_row(joint, text, how="buy", standard=ordered.standard, size=ordered.size,
                      **{"length [mm]": ordered.length, "mass [g]": mass}, vendor="any")]  # fmt: skip
        if washer is not None:
            item = f"{washer['standard']} - {washer['size']} plain washer, steel; mass is with its screw's"
            lines.append(_row(joint, item, how="buy", standard=washer["standard"], size=washer["size"], vendor="any"))
        return lines
    x, y, z = sorted(part["in_link"]["size"], reverse=True)
    name = str(part["part"]).removeprefix(f"{joint.replace(' ', '_')}_").replace("_", " ")
    cut = _CUT.match(made)
    if cut is not None:
        length = float(cut["length"]) + SAW
        item = f"{name}: {cut['what']}, {cut['size']} mm, {cut['length']} mm long; length with {SAW:g} mm for the saw"
        rest = made[cut.end() :].lstrip("; ")
        item += f"; {rest}" if rest else ""
        item += f", {part['material']}" if part["material"] else ""
        return [_row(joint, item, how="cut", size=cut["size"], vendor="any", part=part["part"],
                     **{"length [mm]": f"{length:.1f}", "mass [g]": mass})]  # fmt: skip
    item = f"{name}, {x:.1f} x {y:.1f} x {z:.1f} mm" + (f", {part['material']}" if part["material"] else "")
    if part["family"] == "encoder":
        text = f"{name}, {x:.1f} x {y:.1f} x {z:.1f} mm: the space that is drawn for it"
        return [_row(joint, text, how="buy", vendor="any")]
    cells = {"mass [g]": mass}
    if part.get("volume") is not None:
        cells["print time [h]"] = f"{part['volume']['value'] / PRINT_RATE:.1f}"
    return [_row(joint, item, how=made, part=part["part"], **cells)]


def _merged(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Equal lines combined into one: quantities and masses are added."""
    merged: dict[tuple[str, str], dict[str, str]] = {}
    for row in rows:
        key = (row["joint"], row["item"])
        if key not in merged:
            merged[key] = dict(row)
            continue
        known = merged[key]
        known["quantity"] = str(int(known["quantity"]) + int(row["quantity"]))
        if known["mass [g]"] and row["mass [g]"]:
            known["mass [g]"] = _grams(float(known["mass [g]"]) + float(row["mass [g]"]))
    return list(merged.values())


def _inserts(parts: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """A heat-set insert for every drawn screw that has no nut."""
    found = []
    for part in parts:
        size = re.search(r" - (M[0-9.]+) x ", str(part["made"]))
        if part["family"] != "screw" or size is None or "nut" in str(part["made"]):
            continue
        maker, length = _insert_of(size[1])
        item = f"heat-set insert {size[1]} x {length}, brass; hole as in catalogs/heat_set_inserts.csv"
        found.append(_row(str(part["joint"]), item, how="buy", size=size[1], vendor=maker,
                          **{"length [mm]": length}))  # fmt: skip
    return _merged(found)


def _insert_of(size: str) -> tuple[str, str]:
    """Maker and length of the insert for a screw such as ``M3``."""
    from synth.cad.hardware import inserts

    found = inserts()[float(size.removeprefix("M"))]
    return found.maker, f"{found.length:g}"


def _mount(design: LegDesign) -> list[dict[str, str]]:
    """The four screws that fasten the first joint to the body; their length depends on the user's body."""
    if not design.project.cad.mount:
        return []
    item = "M4 screw for the mount; its length depends on the thickness of your body"
    return [_row(design.built.joints[0].name, item, how="buy", size="M4", vendor="any", quantity="4")]


def _grams(mass: float) -> str:
    return f"{mass:.2f}"
