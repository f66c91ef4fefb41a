"""All values of one catalogue row with units, sources and derived values."""

from __future__ import annotations

import math
from collections.abc import Iterator

from synth.commands.progress import printable
from synth.parts.catalogs import Catalogue
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.row_check import geometric_rates
from synth.parts.rows import DamperRow, TorsionSpringRow
from synth.units import factor

Line = tuple[str, str]


def row_text(row: CatalogueRow, catalogue: Catalogue) -> str:
    """The row as lines ``name  value``: published values, derived values, status and sources."""
    last = ("status", "as_published", "note", "source")
    published = [line for line in _published_lines(row) if line[0] not in last]
    derived = [(f"= {name}", value) for name, value in _derived_lines(row, catalogue)]
    words = [(name, str(getattr(row, name))) for name in last if getattr(row, name)]
    lines = [("family", row.family), *published, *derived, *words, ("stands in", row.place)]
    width = max(len(name) for name, _ in lines)
    return "\n".join(f"{name:<{width}}  {printable(value)}" for name, value in lines)


def stock_text(material: str, catalogue: Catalogue) -> str:
    """The number of stock sizes of a wire material."""
    sizes = [wire.diameter for wire in catalogue.find_material(material).stock() if wire.diameter]
    between = f", {sizes[0] * 1e3:.4g} to {sizes[-1] * 1e3:.4g} mm" if sizes else ""
    return f"{material}: {len(sizes)} stock sizes of known strength{between}"


def _published_lines(row: CatalogueRow) -> Iterator[Line]:
    """The columns; a value that is not the table's says so, as ``status`` says where it is from."""
    assumed = getattr(row, "assumed", ())
    for item in type(row).columns():
        mark = " (not published, see status)" if item.name in assumed else ""
        value = getattr(row, item.name)
        unit, shown = item.metadata["unit"], item.metadata.get("shown", "")
        if value is None or value == "":
            continue
        if isinstance(value, str):
            yield item.name, value + mark
        else:
            scale = 1.0 if unit == shown else factor(shown, unit)
            yield item.name, f"{value / scale:.6g}" + ("" if shown == "1" else f" {shown}") + mark


def _derived_lines(row: CatalogueRow, catalogue: Catalogue) -> Iterator[Line]:
    if isinstance(row, TorsionSpringRow):
        yield from _of_spring(row, catalogue)
    elif isinstance(row, DamperRow):
        yield from _of_damper(row)


def _of_spring(row: TorsionSpringRow, catalogue: Catalogue) -> Iterator[Line]:
    if row.mean_diameter is not None and row.inside is not None and row.wire_diameter:
        yield "mean_diameter", f"{row.mean_diameter * 1e3:.6g} mm"
        yield "inner_diameter", f"{row.inside * 1e3:.6g} mm"
        yield "spring index D/d", f"{row.mean_diameter / row.wire_diameter:.4g}"
    if row.close_wound_length is not None:
        yield "length of touching coils", f"{row.close_wound_length * 1e3:.6g} mm"
    rates = geometric_rates(row, catalogue.known_materials)
    if rates is not None:
        for form, value in zip(("d^4 E/(64 D N)", "10.8 per turn"), rates, strict=True):
            compared = "" if not row.rate else f" ({value / row.rate - 1.0:+.1%} of the published)"
            yield f"rate, {form}", f"{value:.4g} N*m/rad{compared}"


def _of_damper(row: DamperRow) -> Iterator[Line]:
    if row.secant_rate is not None:
        yield "rate at the published point", f"{row.secant_rate:.4g} N*m*s/rad (its lowest)"
    if row.max_torque is None or row.speed is None:
        return
    law, below = row.default_law, row.below_table
    yield (
        "law in use",
        {
            "table": f"table, the measured points{f', {below.words}' if below is not None else ''}",
            "concave": "concave, a power law through the point",
        }[law],
    )
    curve = row.torque_speed()
    for speed, torque in zip(curve.speed, curve.torque, strict=True):
        shown = f"{torque:.4g} N*m, {torque / speed:.4g} N*m*s/rad" if speed else f"{torque:.4g} N*m"
        yield f"torque at {speed / math.tau * 60.0:.4g} rpm", shown
