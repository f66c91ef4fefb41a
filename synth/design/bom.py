"""The list of parts: what to order, wind, cut and print, with vendor, quantity, source and mass."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from synth.design.leg_design import LegDesign
from synth.design.write_design import bought_or_wound
from synth.files.output import write_csv

HEADER = ("joint", "item", "vendor", "part", "quantity", "mass [g]", "source")
BUY = "buy: "  # before the standard part that a drawn screw is
_LISTED = ("spring", "damper")  # families that stand there as bought or wound already


def write_bom(design: LegDesign, parts: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write ``bom.csv``; ``parts`` are those of ``solids.parts`` in ``design.json``, none where nothing was drawn.

    The mass is for the whole line.
    """
    rows = [_with_mass(row, parts) for row in bought_or_wound(design)]
    drawn = [part for part in parts if part["family"] not in _LISTED]
    rows += _merged([_line(part) for part in drawn])
    rows += _inserts(drawn)
    if drawn:
        rows += _screws(design)
    order = {name: index for index, name in enumerate(design.built.joint_names)}
    rows.sort(key=lambda row: order[row["joint"]])
    write_csv(path, {name: [row[name] for row in rows] for name in HEADER})


def _with_mass(row: Mapping[str, str], parts: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """A bought line with the mass of what is drawn of it; a damper's insides are not known."""
    count = int(row["quantity"] or 1)
    wanted = "spring" if "spring" in row["item"] or "wire" in row["item"] else "damper"
    masses = [p["mass"] for p in parts if p["joint"] == row["joint"] and p["family"] == wanted and p["mass"]]
    hands = ", one of each hand" if wanted == "spring" and len(masses) == 2 else ""
    return {**row, "item": row["item"] + hands, "mass [g]": _grams(masses[0]["value"] * count) if masses else ""}


def _line(part: Mapping[str, Any]) -> dict[str, str]:
    x, y, z = sorted(part["size"], reverse=True)
    size = f"{z:.1f} mm across, {x:.1f}" if part["family"] in ("shaft", "link") else f"{x:.1f} x {y:.1f} x {z:.1f}"
    name = str(part["part"]).removeprefix(f"{str(part['joint']).replace(' ', '_')}_").replace("_", " ")
    item = f"{name}, {size} mm" + (f", {part['material']}" if part["material"] else "")
    bought = str(part["made"]).startswith(BUY)
    return {
        "joint": part["joint"],
        "item": str(part["made"]).removeprefix(BUY) if bought else item,
        "vendor": "any" if bought else part["made"],
        "part": "" if bought or part["family"] == "encoder" else part["part"],
        "quantity": "1",
        "mass [g]": "" if part["mass"] is None else _grams(part["mass"]["value"]),
        "source": "drawn here",
    }


def _merged(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Equal lines as one with their number; masses are added."""
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
    """A heat-set insert for every drawn screw: all of them end in one."""
    found = []
    for part in parts:
        size = re.search(r" - (M[0-9.]+) x ", str(part["made"]))
        if part["family"] == "screw" and size is not None:
            item = f"heat-set insert {size[1]}, brass; hole and length as in catalogs/heat_set_inserts.csv"
            found.append(
                {"joint": part["joint"], "item": item, "vendor": "any", "part": "", "quantity": "1", "mass [g]": "",
                 "source": "drawn here"}
            )  # fmt: skip
    return _merged(found)


def _screws(design: LegDesign) -> list[dict[str, str]]:
    """What holds the parts together; lengths follow from the drawing."""
    found = []
    for index, joint in enumerate(design.built.joints):
        mount = index == 0 and design.project.cad.mount
        wanted = [("M3 screw through tube and socket, with nut", 1 if mount else 2), ("M3 screw for the damper", 4)]
        if mount:
            wanted.append(("M4 screw for the mount", 4))
        found += [
            {"joint": joint.name, "item": item, "vendor": "", "part": "", "quantity": str(count), "mass [g]": "",
             "source": "drawn here"}
            for item, count in wanted
        ]  # fmt: skip
    return found


def _grams(mass: float) -> str:
    return f"{mass:.2f}"
