"""A laminate five-bar leg: flat layers, motor mount, hubs, and the assembly in its crouch. Millimetres, degrees.

The leg is one strip: hip tab, upper link, lower link, lower link, upper link, hip tab, with a flexure between
neighbours. Every hinge folds in the same direction, so the same rigid layer is outside at every fold. The gap of this
outer layer is the free length of the film. It is at least ``gap``, which the flexure's rate requires. It is also long
enough that the film's surface strain at the largest fold, t fold / (2 gap) for a film of thickness t with uniform
curvature, is at most ``strain``. The inner layer is cut back so that its edges touch only at the largest fold:
2 T tan(fold/2) for a rigid layer of thickness T.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.cad.hopper_dxf import HOLE_DIAMETER, Layer, write_layer, write_release
from synth.cad.limits import DimensionError, DimensionProblem

TAB = 14.0  # length of a hip tab
HOLE = HOLE_DIAMETER
WALL = 2.0  # mm, of the mount: a choice, five lines of a 0.4 mm nozzle
MOUNT_DEPTH = 12.0  # mm: a choice
PLAY = 0.2  # mm between motor and mount: a choice, about a filament printer's tolerance
# Polyester film: the maker states the strength at 5 % strain (F-5, 10 kg/mm^2, with a modulus of 490), where the film
# has begun to yield; it breaks at 91 % and more (DuPont Teijin Films, Mylar, H-37232-3). Beyond 5 % a hinge has a
# permanent set.
STRAIN = 0.05
KERF = 0.1  # mm, of a CO2 laser in thin sheet; measure the slots of your own laser


@dataclass(frozen=True)
class HopperDimensions:
    """The dimensions of the parts; ``motor``: width and height of its cross-section, equal for a round one."""

    upper: float
    lower: float
    hip_spacing: float
    width: float
    thickness: float
    film: float
    adhesive: float
    gap: float
    adhesive_gap: float
    crouch: float
    extended: float
    shaft: float
    motor: tuple[float, float]
    round_motor: bool
    sheet: float
    strain: float = STRAIN
    kerf: float = KERF

    def hinge_gap(self, fold: float) -> float:
        """Free length of film (mm) at a hinge with this fold (deg): for its rate, and for the film's strain."""
        return max(self.gap, 0.5 * self.film * math.radians(fold) / self.strain)

    def film_strain(self, fold: float) -> float:
        """Surface strain of the film at a fold (deg)."""
        return 0.5 * self.film * math.radians(fold) / self.hinge_gap(fold)

    @property
    def rigid(self) -> float:
        """Thickness of one rigid layer, mm: half of the laminate without film and adhesive."""
        return 0.5 * (self.thickness - self.film - 2 * self.adhesive)

    @property
    def arm(self) -> float:
        """Distance of the hub's arm's holes from the shaft axis, mm."""
        return 0.5 * self.shaft + WALL + 0.5 * TAB

    def lower_angle(self, upper: float) -> float:
        """Lower link's angle, deg, at an upper link's (both from straight down)."""
        share = (0.5 * self.hip_spacing + self.upper * math.sin(math.radians(upper))) / self.lower
        return math.degrees(math.asin(share))

    @property
    def folds(self) -> tuple[float, float, float]:
        """Largest fold from flat of hip, knee and foot, deg, over the leg's travel."""
        knee = self.crouch + self.lower_angle(self.crouch)
        return 90.0 - self.extended, knee, 180.0 - 2 * self.lower_angle(self.extended)

    def cut_back(self, fold: float) -> float:
        """Gap of the inner rigid layer for a fold."""
        return max(self.hinge_gap(fold), 2 * self.rigid * math.tan(math.radians(0.5 * fold)) + self.adhesive_gap)

    def require(self) -> None:
        """Raise DimensionError if no such laminate can be made."""
        problems = []
        if self.rigid <= 0.0:
            reason = "film and adhesive are thicker than the laminate"
            problems.append(DimensionProblem("laminate.thickness", self.thickness, "above film and adhesive", reason))
        elif max(self.cut_back(fold) for fold in self.folds) > 0.5 * min(self.upper, self.lower):
            reason = "the inner layer would be cut back by more than half a link to let the foot fold so far"
            problems.append(DimensionProblem("laminate.thickness", self.thickness, "a thinner one", reason))
        if self.hip_spacing < self.motor[0] + PLAY:
            reason = "the two motors would overlap; they must stand behind each other, which is not drawn"
            allowed = f"at least {self.motor[0] + PLAY:g} mm"
            problems.append(DimensionProblem("leg.hip_spacing", self.hip_spacing, allowed, reason))
        if problems:
            raise DimensionError(problems)


@dataclass(frozen=True)
class HopperParts:
    """The result: layers, STEP files, hinges' dimensions, and warnings."""

    layers: tuple[Layer, ...]
    files: tuple[str, ...]
    gaps: dict[str, float]
    notes: tuple[str, ...]


def hinges(dimensions: HopperDimensions) -> list[tuple[str, float, float]]:
    """Name, place along the strip and largest fold of the five hinges."""
    d = dimensions
    hip, knee, foot = d.folds
    places = [TAB, d.upper, d.lower, d.lower, d.upper]
    names = [("hip", hip), ("knee", knee), ("foot", foot), ("knee", knee), ("hip", hip)]
    found, x = [], 0.0
    for (name, fold), way in zip(names, places, strict=True):
        x += way
        found.append((name, x, fold))
    return found


def layers(dimensions: HopperDimensions) -> tuple[Layer, ...]:
    """The five layers from outside to inside, as closed outlines and fold lines."""
    d = dimensions
    marks = hinges(d)
    end = marks[-1][1] + TAB
    folds = tuple(x for _, x, _ in marks)
    # Of each hip, the tab's on the body and the upper link's for the hub's arm.
    near = (0.5 * TAB, TAB + d.arm)
    places = (*near, *(end - x for x in reversed(near)))
    holes = tuple((x, y) for x in places for y in (0.25 * d.width, 0.75 * d.width))

    def plates(gaps: list[float]) -> tuple[tuple[float, float], ...]:
        """Begin and end of each plate along the strip."""
        edges = [0.0, *(e for x, gap in zip(folds, gaps, strict=True) for e in (x - gap / 2, x + gap / 2)), end]
        return tuple(zip(edges[::2], edges[1::2], strict=True))

    outer = plates([d.hinge_gap(fold) for _, _, fold in marks])
    inner = plates([d.cut_back(fold) for _, _, fold in marks])
    bonded_outer = plates([d.hinge_gap(fold) + 2 * d.adhesive_gap for _, _, fold in marks])
    bonded_inner = plates([d.cut_back(fold) + 2 * d.adhesive_gap for _, _, fold in marks])
    return (
        Layer("1_outer_rigid", "rigid", d.rigid, d.width, outer, folds, holes),
        Layer("2_adhesive", "adhesive", d.adhesive, d.width, bonded_outer, folds, holes),
        Layer("3_film", "film", d.film, d.width, ((0.0, end),), folds, holes),
        Layer("4_adhesive", "adhesive", d.adhesive, d.width, bonded_inner, folds, holes),
        Layer("5_inner_rigid", "rigid", d.rigid, d.width, inner, folds, holes),
    )


def _cut_note(marks: Sequence[tuple[str, float, float]], length: float, sheet: float) -> str:
    """Where to cut a strip that is longer than the sheet (mm): at the fewest hinges, ``marks`` as of ``hinges``."""
    text = f"the strip is {length:.0f} mm long, the sheet {sheet:.0f} mm: "
    begin, cuts = 0.0, list[str]()
    while length - begin > sheet:
        reached = [(name, x) for name, x, _ in marks if begin < x <= begin + sheet]
        if not reached:
            beyond = min(x for _, x, _ in marks if x > begin)
            return f"{text}the link from {begin:.0f} to {beyond:.0f} mm does not fit either; use a larger sheet"
        name, begin = reached[-1]
        cuts.append(f"{name} ({begin:.0f} mm)")
    pieces = f"cut it in {len(cuts) + 1} pieces at the hinge{'s' if len(cuts) > 1 else ''} of {' and '.join(cuts)}"
    return f"{text}{pieces} and join the film there"


def mount(dimensions: HopperDimensions) -> Any:
    """The body between the hips: two motor pockets with shafts ``hip_spacing`` apart, and walls."""
    import cadquery as cq

    d = dimensions
    wide, high = d.motor
    outline = cq.Workplane("XY").box(d.hip_spacing + wide + PLAY + 2 * WALL, high + PLAY + 2 * WALL, MOUNT_DEPTH)
    points = [(-0.5 * d.hip_spacing, 0.0), (0.5 * d.hip_spacing, 0.0)]
    pockets = outline.faces(">Z").workplane().pushPoints(points)
    made = pockets.hole(wide + PLAY) if d.round_motor else pockets.rect(wide + PLAY, high + PLAY).cutThruAll()
    return made.val()


def hub(dimensions: HopperDimensions) -> Any:
    """A hub on the motor's D shaft with a flat arm that is screwed to the upper link, beyond its hip hinge."""
    import cadquery as cq

    d = dimensions
    radius = 0.5 * d.shaft + WALL
    body = cq.Workplane("XY").circle(radius).extrude(d.width)
    arm = cq.Workplane("XY").box(TAB + radius, WALL, d.width, centered=(False, True, False))
    made = body.union(arm)
    flat = 0.5 * d.shaft - 0.5  # the usual D: half a millimetre off a 3 mm shaft
    bore = cq.Workplane("XY").circle(0.5 * d.shaft + 0.05).extrude(d.width)
    keep = cq.Workplane("XY").box(2 * d.shaft, d.shaft, d.width, centered=(True, False, False))
    bore = bore.cut(keep.translate((0.0, flat, 0.0)))
    made = made.cut(bore)
    holes = [(d.arm, 0.25 * d.width), (d.arm, 0.75 * d.width)]
    drilled = cq.Workplane("XZ").pushPoints(holes).circle(0.5 * HOLE).extrude(2 * radius, both=True)
    return made.cut(drilled).val()


def assembly(dimensions: HopperDimensions) -> Any:
    """Mount, hubs and the four links in the crouch, x to the right, y up, the width along z.

    A link begins at its hip axis, in the room of the hub: ``hip_note`` says so.
    """
    import cadquery as cq

    d = dimensions
    made = cq.Assembly(name="leg")
    made.add(cq.Workplane(obj=mount(d)), name="mount", color=cq.Color(0.3, 0.47, 0.66),
             loc=cq.Location(cq.Vector(0, 0, -0.5 * MOUNT_DEPTH)))  # fmt: skip
    lower = d.lower_angle(d.crouch)
    for side, name in ((1, "right"), (-1, "left")):
        hip = (side * 0.5 * d.hip_spacing, 0.0)
        turn = math.radians(d.crouch)
        knee = (hip[0] + side * d.upper * math.sin(turn), hip[1] - d.upper * math.cos(turn))
        foot = (0.0, knee[1] - d.lower * math.cos(math.radians(lower)))
        for piece, start, end in (("upper", hip, knee), ("lower", knee, foot)):
            made.add(_link(d, start, end), name=f"{piece}_{name}", color=cq.Color(0.95, 0.56, 0.17))
        arm = 90.0 - d.crouch if side > 0 else 90.0 + d.crouch
        place = cq.Location(cq.Vector(*hip, 0.0), cq.Vector(0, 0, 1), -arm)
        made.add(cq.Workplane(obj=hub(d)), name=f"hub_{name}", loc=place, color=cq.Color(0.55, 0.56, 0.6))
    return made


def _link(d: HopperDimensions, start: tuple[float, float], end: tuple[float, float]) -> Any:
    """A link between two hinge axes, minus half of the longest hinge at each end."""
    import cadquery as cq

    length = math.dist(start, end) - max(d.hinge_gap(fold) for fold in d.folds)
    angle = math.degrees(math.atan2(end[1] - start[1], end[0] - start[0]))
    middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]), 0.5 * d.width)
    return cq.Workplane("XY").box(length, d.thickness, d.width).rotate((0, 0, 0), (0, 0, 1), angle).translate(middle)


def hip_note(dimensions: HopperDimensions) -> str:
    """What of the hip is not designed yet."""
    d = dimensions
    return (
        "the hip is not complete: the leg is simulated with each motor's shaft fixed to the upper link and the hip's "
        "flexure between body and link, its fold line on the shaft axis. There the hub is, "
        f"{d.shaft + 2 * WALL:g} mm across: cut the strip round it (in leg_assembly.step hub and link overlap). Screw "
        f"the hub's arm to the upper link, {d.arm:g} mm from the fold, never to the hip tab, which would put the soft "
        f"flexure between motor and link; the tab's holes, {0.5 * TAB:g} mm from the fold, belong to the body, and the "
        "mount has no seat for them yet"
    )


def _strain_notes(dimensions: HopperDimensions) -> list[str]:
    """Hinges longer than their rate requires, and their remaining rate, ``E w t^3 / (12 gap)``."""
    d, notes = dimensions, []
    for name, _, fold in hinges(d)[:3]:
        gap = d.hinge_gap(fold)
        if gap <= d.gap * (1.0 + 1e-9):
            continue
        before = 0.5 * d.film * math.radians(fold) / d.gap
        notes.append(
            f"{name}: with the gap of {d.gap:.2f} mm that the rate requires, the film would be strained by "
            f"{before:.0%} at a fold of {fold:.0f} deg. The drawn gap is {gap:.2f} mm with a strain of {d.strain:.0%}, "
            f"and the flexure has {d.gap / gap:.0%} of the simulated rate. Enter that rate under flexures, or use a "
            "stiffer joint"
        )
    return notes


def export_hopper(dimensions: HopperDimensions, folder: Path) -> HopperParts:
    """Write a DXF per layer, and STEP files of mount, hub and the whole leg.

    Raises
    ------
    DimensionError : before anything is written, where no such laminate or mount can be made.
    """
    import cadquery as cq

    from synth.cad.export import write_step

    dimensions.require()
    folder.mkdir(parents=True, exist_ok=True)
    made = layers(dimensions)
    files = []
    for layer in made:
        write_layer(layer, folder / f"{layer.name}.dxf", dimensions.kerf)
        files.append(f"{layer.name}.dxf")
    write_release(made[0], folder / "6_release_cut.dxf", dimensions.kerf)
    files.append("6_release_cut.dxf")
    for name, solid in (("motor_mount", mount(dimensions)), ("hub", hub(dimensions))):
        write_step(cq.Assembly(name=f"{name}_part").add(cq.Workplane(obj=solid), name=name), folder / f"{name}.step")
        files.append(f"{name}.step")
    write_step(assembly(dimensions), folder / "leg_assembly.step")
    files.append("leg_assembly.step")
    length = made[0].plates[-1][1]
    notes = [hip_note(dimensions)]
    if length > dimensions.sheet:
        notes.append(_cut_note(hinges(dimensions), length, dimensions.sheet))
    notes += _strain_notes(dimensions)
    three = hinges(dimensions)[:3]
    gaps = {f"{name}_hinge_gap": dimensions.hinge_gap(fold) for name, _, fold in three}
    gaps |= {f"{name}_inner_gap": dimensions.cut_back(fold) for name, _, fold in three}
    return HopperParts(made, tuple(files), gaps, tuple(notes))
