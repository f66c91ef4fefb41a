"""The bill of materials: parts to order, wind, cut and print, with standard, size, length, vendor, quantity and mass.

The vendor column has only vendors: ``any`` for standard parts that every dealer sells, empty for parts to make. The
built-in catalogues have no prices; the price column, per piece, comes from the user's own table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.leg_design import LegDesign
from synth.design.leg_reach import cut_words
from synth.design.spring_hands import hands_of, is_pair
from synth.files.output import write_csv
from synth.parts.rows import TorsionSpringRow
from synth.spring.hand_words import hand_words
from synth.spring.spring_result import WIRE_ALLOWANCE

if TYPE_CHECKING:
    from synth.cad import JointDimensions
    from synth.cad.standard_part import CutPart, StandardPart

LISTED = ("spring", "damper")  # families that are listed as bought or wound already
SAW = 3.0  # mm of extra length of rods and tubes: saw cut and facing
# mm^3 of solid part an hour: PrusaSlicer 2.5.0 gave 3 h 4 min for 38.5 cm^3 of a clevis at its defaults (research of
# this project, 0.4 mm nozzle); a Markforged with fill as dense takes about as long.
PRINT_RATE = 38.5e3 / (3 + 4 / 60)


@dataclass(frozen=True)
class BomLine:
    """A line of the bill; ``mass`` (g) and ``print_time`` (h) are for the whole line, None where not known.

    ``length`` : mm, with as many digits as it is to be ordered with. ``family`` : of a spring's or damper's line;
    ``place`` : which of the joint's drawn ones it is for, None: all. ``drawn`` : their names.
    """

    joint: str
    item: str
    how: str = "buy"
    standard: str = ""
    size: str = ""
    length: str = ""
    vendor: str = ""
    part: str = ""
    quantity: int = 1
    price: str = ""
    mass: float | None = None
    print_time: float | None = None
    source: str = "drawn here"
    family: str = ""
    place: int | None = None
    drawn: tuple[str, ...] = ()

    def cells(self) -> dict[str, str]:
        """The line's cells by column."""
        return {
            "joint": self.joint, "item": self.item, "how": self.how, "standard": self.standard, "size": self.size,
            "length [mm]": self.length, "vendor": self.vendor, "part": self.part, "quantity": str(self.quantity),
            "price": self.price, "mass [g]": "" if self.mass is None else f"{self.mass:.2f}",
            "print time [h]": "" if self.print_time is None else f"{self.print_time:.1f}", "source": self.source,
        }  # fmt: skip

    def __str__(self) -> str:
        ordered = ", ".join(text for text in (self.item, self.vendor, self.part) if text)
        return f"{ordered} ({self.quantity} in the bill)"


def write_bom(
    design: LegDesign,
    parts: Sequence[Mapping[str, Any]],
    orders: Mapping[str, StandardPart | CutPart],
    path: Path,
) -> dict[str, str]:
    """Write ``bom.csv``.

    Parameters
    ----------
    parts
        the entries of ``solids.parts`` in ``design.json``, empty if nothing was drawn.
    orders
        by name, what each of them that is bought by a standard or cut is ordered by.

    Returns
    -------
    By name, the line of each drawn part in words.
    """
    lines = [_with_drawn(line, parts) for line in bought_or_wound(design)]
    drawn = [part for part in parts if part["family"] not in LISTED]
    lines += merge_lines(line for part in drawn for line in _lines(part, orders.get(part["part"])))
    lines += _inserts(drawn, orders)
    if drawn:
        lines += _mount(design) + _magnets(design)
    order = {name: index for index, name in enumerate(design.built.joint_names)}
    lines.sort(key=lambda line: order[line.joint])
    rows = [line.cells() for line in lines]
    write_csv(path, {name: [row[name] for row in rows] for name in BomLine("", "").cells()})
    return {name: str(line) for line in lines for name in line.drawn}


def bought_or_wound(design: LegDesign) -> list[BomLine]:
    """Springs and dampers as lines, joint by joint."""
    chosen = zip(design.built.joints, design.springs.chosen, design.dampers.chosen, strict=True)
    drawn = (None,) * len(design.built.joints) if design.drawn is None else design.drawn.dimensions.joints
    return [
        line
        for (joint, spring, damper), dimensions in zip(chosen, drawn, strict=True)
        for line in (*_spring_lines(joint.name, spring, dimensions), _damper_line(joint.name, damper))
    ]


def _spring_lines(joint: str, option: SpringOption, drawn: JointDimensions | None = None) -> list[BomLine]:
    """Springs to buy, of a pair a line for each hand; or lengths of wire with the allowance for winding."""
    if option.row is not None:
        return _bought_lines(joint, option, option.row, drawn)
    hands = f", {hand_words(hands_of(option))}" if option.number > 1 else ""
    design = option.design
    assert design is not None
    item = (
        f"{design.material.removesuffix(' wire')} wire, {design.wire_diameter * 1e3:.4g} mm, "
        f"{design.wire_length * 1e3:.0f} mm a spring: wind {design.body_coils:.4g} coils on "
        f"{design.mean_diameter * 1e3:.4g} mm mean diameter; length with {WIRE_ALLOWANCE * 1e3:.0f} mm to hold and trim"
    )
    return [BomLine(joint, item + hands, "wind", size=f"{design.wire_diameter * 1e3:.4g} mm",
                    length=f"{design.cut_length * 1e3:.0f}", vendor="any", quantity=design.count,
                    source=design.strength_source, family="spring")]  # fmt: skip


def _bought_lines(
    joint: str, option: SpringOption, row: TorsionSpringRow, drawn: JointDimensions | None
) -> list[BomLine]:
    """Springs of one part, or of a pair the part and that of the other hand, by its number if a catalogue has it."""

    def line(of: TorsionSpringRow, more: str, quantity: int, place: int | None) -> BomLine:
        more += cut_words(of.leg_length, drawn)
        item = f"torsion spring, {_rates(option.rate / option.count, of.rate)}{more}{_to_measure(of.measure)}"
        return BomLine(joint, item, vendor=of.vendor, part=of.part, quantity=quantity, price=of.price,
                       source=of.source, family="spring", place=place)  # fmt: skip

    if not is_pair(option):
        hands = hand_words(hands_of(option))
        as_drawn = "" if drawn is None else f", drawn {hands}"
        return [line(row, f", {hands}" if row.hand else as_drawn, option.count, None)]
    first, second = (f"{hand}-hand" for hand in hands_of(option)) if row.hand else ("one hand", "the other hand")
    lines = [line(row, f", {first}", 1, 0)]
    if option.mirror is not None:
        return [*lines, line(option.mirror, f", {second}", 1, 1)]
    other = line(row, f", {second}: the mirror image of {row.part}, in no catalogue; ask for it", 1, 1)
    return [*lines, replace(other, part="", price="")]


def _rates(held: float, sold: float | None) -> str:
    """The rate (N m/rad) by which a part is recognised on arrival, and that in the joint, which clamps its arms."""
    in_joint = f"{held:.4g} N*m/rad in the joint"
    return in_joint if sold is None else f"{sold:.4g} N*m/rad as sold, {in_joint}"


def _damper_line(joint: str, option: DamperOption) -> BomLine:
    row, arrangement = option.row, option.arrangement
    item = "rotary damper" + _to_measure(row.measure if row is not None else ())
    if row is not None and row.max_torque is not None and row.speed is not None:
        item += f", {row.max_torque:.4g} N*m at {row.speed * 30 / pi:.4g} rpm"
    if arrangement.ratio != 1.0:
        item += f", turning {arrangement.ratio:g} times as fast as the joint"
    if arrangement.pair:
        item += ", in pairs, one for each direction"
    line = BomLine(joint, item, part=option.part, quantity=arrangement.pieces, source=option.why, family="damper")
    if row is None:
        return line
    return replace(line, vendor=row.vendor, part=row.order, price=row.price, source=row.source)


def _to_measure(what: Sequence[str]) -> str:
    return f" (measure before printing: {', '.join(what)})" if what else ""


def _with_drawn(line: BomLine, parts: Sequence[Mapping[str, Any]]) -> BomLine:
    """A spring's or damper's line with the mass of the drawn part, where it is known: of no damper's envelope."""
    drawn = [part for part in parts if part["joint"] == line.joint and part["family"] == line.family]
    drawn = drawn if line.place is None else drawn[line.place : line.place + 1]
    masses = [part["mass"]["value"] for part in drawn if part["mass"]]
    mass = masses[0] * line.quantity if masses else None
    return replace(line, mass=mass, drawn=tuple(str(part["part"]) for part in drawn))


def _lines(part: Mapping[str, Any], order: StandardPart | CutPart | None) -> list[BomLine]:
    """A drawn part's line, and that of the washer under a screw's head."""
    from synth.cad.standard_part import CutPart, StandardPart

    joint, name = str(part["joint"]), str(part["part"])
    mass = None if part["mass"] is None else float(part["mass"]["value"])
    if isinstance(order, StandardPart):
        return _standard_lines(joint, order, mass, name)
    x, y, z = part["box"]
    what = name.removeprefix(f"{joint.replace(' ', '_')}_").replace("_", " ")
    of_material = f", {part['material']}" if part["material"] else ""
    if isinstance(order, CutPart):
        item = f"{what}: {order.designation}; length with {SAW:g} mm for the saw; {order.work}{of_material}"
        return [BomLine(joint, item, "cut", size=order.size, length=f"{order.length + SAW:.1f}", vendor="any",
                        part=name, mass=mass, drawn=(name,))]  # fmt: skip
    item = f"{what}, {x:.1f} x {y:.1f} x {z:.1f} mm"
    if part["family"] == "encoder":
        return [BomLine(joint, f"{item}: the space that is drawn for it", vendor="any", drawn=(name,))]
    volume = part.get("volume")
    hours = None if volume is None else volume["value"] / PRINT_RATE
    return [BomLine(joint, item + of_material, str(part["made"]), part=name, mass=mass, print_time=hours,
                    drawn=(name,))]  # fmt: skip


def _standard_lines(joint: str, order: StandardPart, mass: float | None, name: str) -> list[BomLine]:
    """The line of a standard part, and that of its washer."""
    length = "" if order.length is None else f"{order.length:g}"
    lines = [BomLine(joint, order.designation, standard=order.standard, size=order.size, length=length, vendor="any",
                     mass=mass, drawn=(name,))]  # fmt: skip
    if order.washer:
        item = f"{order.washer} - {order.washer_size} plain washer, steel; mass is with its screw's"
        lines.append(BomLine(joint, item, standard=order.washer, size=order.washer_size, vendor="any"))
    return lines


def merge_lines(lines: Iterable[BomLine]) -> list[BomLine]:
    """Equal lines combined into one: quantities, masses and times are added."""
    found: dict[tuple[str, str], BomLine] = {}
    for line in lines:
        known = found.get((line.joint, line.item))
        found[line.joint, line.item] = line if known is None else replace(
            known,
            quantity=known.quantity + line.quantity,
            mass=_sum(known.mass, line.mass),
            print_time=_sum(known.print_time, line.print_time),
            drawn=known.drawn + line.drawn,
        )  # fmt: skip
    return list(found.values())


def _sum(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else one + other


def _inserts(parts: Sequence[Mapping[str, Any]], orders: Mapping[str, StandardPart | CutPart]) -> list[BomLine]:
    """A heat-set insert for every drawn screw that has no nut."""
    from synth.cad.hardware import inserts
    from synth.cad.insert_bodies import insert_mass
    from synth.cad.standard_part import StandardPart

    found = []
    for part in parts:
        order = orders.get(part["part"])
        if not isinstance(order, StandardPart) or not order.has_insert:
            continue
        assert order.thread is not None
        insert = inserts()[order.thread]
        item = f"heat-set insert {order.size} x {insert.length:g}, brass; hole as in catalogs/heat_set_inserts.csv"
        found.append(BomLine(str(part["joint"]), item, size=order.size, length=f"{insert.length:g}",
                             vendor=insert.maker, mass=insert_mass(insert)))  # fmt: skip
    return merge_lines(found)


def _mount(design: LegDesign) -> list[BomLine]:
    """The four screws that fasten the first joint to the body; their length depends on the user's body."""
    if not design.project.cad.mount:
        return []
    item = "M4 screw for the mount; its length depends on the thickness of your body"
    return [BomLine(design.built.joints[0].name, item, size="M4", vendor="any", quantity=4)]


def _magnets(design: LegDesign) -> list[BomLine]:
    """The magnet in the shaft's end below each angle sensor, of its pocket's size."""
    found = []
    for joint in () if design.drawn is None else design.drawn.dimensions.joints:
        if joint.encoder is not None:
            wide, deep = joint.encoder.magnet_diameter, joint.encoder.magnet_depth
            item = f"magnet of the angle sensor, {wide:g} x {deep:g} mm, magnetised across its diameter; glued in"
            found.append(BomLine(joint.name, item, size=f"{wide:g} mm", length=f"{deep:g}", vendor="any"))
    return found
