"""Encoder seat, damper adapter and mount: they pass every gate, fit their places, and are refused by name."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from cad_joints import cleared
from synth.cad import (
    AdapterDimensions,
    BoreDimensions,
    DamperDimensions,
    DimensionError,
    EncoderDimensions,
    JointDimensions,
    LegDimensions,
    LoadDimensions,
    MountDimensions,
    PrintDimensions,
    SpringDimensions,
    build_leg,
    check_leg,
    export_leg,
)
from synth.cad.arm_shaft import flat_distance
from synth.cad.checked_layout import lay_out
from synth.cad.checks import check_axial_play, check_keyed, check_part, check_screws
from synth.cad.damper_bracket import bracket_volume, build_bracket, key_turn
from synth.cad.damper_side import damper_side, sleeve_of
from synth.cad.joint import build_joint, orient
from synth.cad.layout import damper_screws
from synth.cad.outline import unit
from synth.cad.parts import mesh_of
from synth.cad.printing import check_printing, wall_thickness
from synth.cad.strength import stresses
from synth.cad.travel import Bodies, check_travel, check_within, manifold

HIP = cleared(
    JointDimensions(
        "hip",
        SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0),
        110.0,
        110.0,
        range=(80.0, 140.0),
        damper=DamperDimensions(adapter=AdapterDimensions(6.0, 12.0, 16.0)),
        loads=LoadDimensions(1.0, 0.1),
        encoder=EncoderDimensions(),
        mount=MountDimensions(),
    )
)


@pytest.fixture(scope="module")
def hip():
    return build_leg(LegDimensions("one", (HIP,)))


def heights(part):
    return part.mesh.vertices[:, 2].min(), part.mesh.vertices[:, 2].max()


def test_a_joint_with_everything_passes_every_gate(hip):
    checks = check_leg(hip)
    assert [str(check) for check in checks if not check.passed] == []
    assert {"encoder_seat", "damper_adapter", "encoder"} <= {part.family for part in hip.parts}


def test_adapter_is_pinned_on_the_shaft_and_open_to_the_damper(hip):
    joint = hip.joints[0]
    adapter, shaft, pin = (manifold(joint.part(name).mesh) for name in ("damper_adapter", "shaft", "damper_pin"))
    assert (adapter ^ shaft).volume() < 0.05
    for held in (adapter, shaft):
        assert (held ^ pin).volume() < 0.05
        assert (held ^ pin.rotate((0.0, 0.0, 15.0))).volume() > 1.0
    # The shaft goes in by its grip, measured on the solids.
    low, high = heights(joint.part("damper_adapter"))
    bottom, top = heights(joint.part("shaft"))
    assert min(high, top) - max(low, bottom) == pytest.approx(16.0, abs=1e-6)
    assert high - low == pytest.approx(12.0 + 2.0 + 16.0)


@pytest.mark.parametrize(
    ("damper", "parts"),
    [
        (DamperDimensions(bore=BoreDimensions("square", 6.0)), set()),
        (DamperDimensions(bore=BoreDimensions("square", 14.0)), {"damper_insert", "damper_pin"}),
        (DamperDimensions(bore=BoreDimensions("hex", 14.0)), {"damper_insert", "damper_pin"}),
        (
            DamperDimensions(adapter=AdapterDimensions(8.0, 12.0, 16.0, form="round")),
            {"damper_adapter", "damper_pin", "damper_output_pin"},
        ),
        (
            DamperDimensions(adapter=AdapterDimensions(8.0, 12.0, 16.0, form="hex")),
            {"damper_adapter", "damper_pin", "damper_set_screw"},
        ),
    ],
    ids=["milled square", "square insert", "hex insert", "round shaft", "hex shaft"],
)
def test_every_form_of_a_damper_s_shaft_or_bore_is_drawn(damper, parts):
    joint = build_joint(cleared(replace(HIP, damper=damper, encoder=None)))
    found = {part.name.removeprefix("hip_") for part in joint.parts}
    wanted = {"damper_insert", "damper_adapter", "damper_pin", "damper_output_pin", "damper_set_screw"}
    assert found & wanted == parts
    for part in joint.parts:
        if part.name.removeprefix("hip_") in {*parts, "shaft", "damper_bracket", "damper"}:
            assert [str(check) for check in check_part(part) if not check.passed] == []
    bodies = Bodies(joint)
    checks = [*check_within(bodies), *check_axial_play(bodies), *check_keyed(joint), *check_screws(joint)]
    assert [str(check) for check in checks if not check.passed] == []
    assert bodies.round_overlap() < 0.05
    if not parts:  # the shaft's own end is the square: across flats and at its corners, measured on the solid
        low = joint.part("shaft").mesh.vertices[:, 2].min()
        end = joint.part("shaft").mesh.vertices
        end = end[np.abs(end[:, 2] - low) < 1e-6]
        assert np.abs(end[:, :2]).max() == pytest.approx(3.0, abs=1e-6)


def test_the_hub_of_a_round_bore_holds_the_shaft():
    """A set screw gets a flat, D of the shaft's own 8 mm; an unknown hub is said on the shaft."""
    for hub, width in (("set_screw", 4.0 + flat_distance("d", 8.0)), ("unknown", 8.0)):
        damper = DamperDimensions(bore=BoreDimensions("round", 8.0, hub))
        shaft = build_joint(cleared(replace(HIP, damper=damper, encoder=None))).part("shaft")
        end = shaft.mesh.vertices
        end = end[np.abs(end[:, 2] - end[:, 2].min()) < 1e-6]
        assert np.ptp(end[:, 0]) == pytest.approx(width, abs=0.02)
        assert ("still to be made to drive the damper" in str(shaft.made)) == (hub == "unknown")


def test_a_milled_end_bears_the_damper_s_torque():
    """16 T/(pi a^3) of a square a: 1.91 N m on 6 mm is 45 MPa."""
    damper = DamperDimensions(bore=BoreDimensions("square", 6.0))
    loads = LoadDimensions(damper_torque=1.91)
    joint = cleared(replace(HIP, damper=damper, loads=loads, encoder=None))
    found = {each.name: each.value for each in stresses(joint, lay_out(joint), PrintDimensions())}
    assert found["shaft's end, torsion"] == pytest.approx(45.04, abs=0.01)
    pressure = 3 * 1910 / (4 * 3.0**2 * 0.8 * damper.body_length)
    assert found["shaft's end in the damper, pressure"] == pytest.approx(pressure)


def test_assumed_damper_sizes_are_listed_on_the_part():
    damper = DamperDimensions(unknown=("bolt circle (cad.dampers.hip.bolt_circle)",))
    joint = build_joint(cleared(replace(HIP, damper=damper, encoder=None)))
    assert "drawn by assumption: bolt circle (cad.dampers.hip.bolt_circle)" in str(joint.part("damper").made)


def test_encoder_faces_the_magnet_at_its_air_gap(hip):
    joint, encoder = hip.joints[0], HIP.encoder
    shaft, sensor = (heights(joint.part(name)) for name in ("shaft", "encoder"))
    assert joint.layout.flips[1] > 0
    assert sensor[0] - shaft[1] == pytest.approx(max(encoder.air_gap, 1.2))
    collar = heights(joint.part("collar_b"))
    assert shaft[1] == pytest.approx(collar[1])


def free_ways(joint):
    """Directions (deg) from which a straight key of 2 mm and 60 mm reaches collar A, at one of the stops."""
    low, high = heights(joint.part("collar_a"))
    key = Manifold.cylinder(60.0, 1.0, 1.0, 24).rotate((0.0, 90.0, 0.0))
    key = key.translate((joint.dimensions.hardware.radius + 0.3, 0.0, (low + high) / 2))
    found = set()
    for angle in joint.dimensions.stop_angles:
        bodies = [joint.mesh_at(part, angle).manifold for part in joint.parts if part.group != "spring"]
        ways = {turn: key.rotate((0.0, 0.0, turn)) for turn in range(0, 360, 15)}
        found |= {turn for turn, rod in ways.items() if all((rod ^ body).volume() < 0.01 for body in bodies)}
    return found


def test_a_straight_key_reaches_the_set_screw_of_the_collar_in_the_sleeve(hip):
    """A mount's flange stood 28 mm behind the hole, less than a key's long arm; so did a tube wider than the joint."""
    assert free_ways(hip.joints[0])
    wide = replace(HIP, encoder=None, mount=None, link_width=50.0, range=(90.0, 140.0))
    assert free_ways(build_joint(cleared(wide)))


@pytest.mark.parametrize(
    ("form", "fastened", "change"),
    [
        ("d", "damper_set_screw", {}),
        ("round", "damper_output_pin", {}),
        ("hex", "damper_set_screw", {"closes": 1, "sign": -1}),
        ("d", "damper_set_screw", {"free_angle": 135.0, "rest_angle": 135.0, "range": (127.0, 143.0)}),
    ],
    ids=["set screw", "pin", "mirrored", "at a boss"],
)
def test_the_travel_brings_the_adapter_s_fastening_to_its_hole_in_the_sleeve(form, fastened, change):
    """Set screw and pin turn with the lower half: at none of its angles did they face the hole."""
    damper = replace(HIP.damper, adapter=AdapterDimensions(6.0, 12.0, 16.0, form=form))
    dimensions = cleared(replace(HIP, damper=damper, mount=None, encoder=None, **change))
    layout = lay_out(dimensions)
    sleeve = sleeve_of(dimensions, layout)
    flips = layout.flips
    bracket = orient(build_bracket(sleeve, layout.screws).translate((0, 0, -layout.gap_a - layout.ear)), flips)
    exact = bracket_volume(sleeve, layout.screws)
    assert exact is None or bracket.Volume() == pytest.approx(exact, rel=1e-4)
    (part,) = (orient(each.solid, flips) for each in damper_side(dimensions, layout) if each.suffix == fastened)
    middle = part.Center()
    along = np.array([1.0, 0.0]) if form != "round" else np.array([0.0, 1.0])
    rod = Manifold.cylinder(80.0, 1.0, 1.0, 24).rotate((0.0, 90.0, 0.0)).translate((0.0, 0.0, middle.z))
    start = math.degrees(math.atan2(along[1], flips[0] * along[0]))
    body = mesh_of(bracket).manifold
    low, high = dimensions.stop_angles
    free = [
        angle
        for angle in np.arange(low, high, 0.5)
        for end in ((0.0, 180.0) if form == "round" else (0.0,))
        if (rod.rotate((0.0, 0.0, start + end + dimensions.rotation(angle))) ^ body).volume() < 0.01
    ]
    assert free


@pytest.mark.parametrize("count", range(2, 13))
def test_the_hole_for_the_collar_s_key_is_between_two_screws_away_from_the_upper_link(count):
    x, y = unit(key_turn(count))
    assert y <= -0.5
    beside = [x * at[0] + y * at[1] for at in damper_screws(replace(HIP.damper, bolt_count=count, bolt_circle=2.0))]
    assert max(beside) == pytest.approx(np.cos(np.pi / count))


def test_mount_screws_clear_the_ears(hip):
    """A rod through each hole of the flange, and a head's width round it, meets nothing of the upper half."""
    import cadquery as cq

    from synth.cad.outlines import mount_screws

    joint = hip.joints[0]
    upper, start = joint.part("upper").solid, joint.layout.upper_bottom
    flip_x, flip_z = joint.layout.flips
    up, bolt = cq.Vector(0, 1, 0), HIP.mount.bolt_diameter
    for x, z in mount_screws(HIP, joint.layout):
        x, z = flip_x * x, flip_z * z
        rod = cq.Solid.makeCylinder(bolt / 2 - 0.05, 40.0, cq.Vector(x, start - bolt, z), up)
        assert upper.intersect(rod).Volume() < 1e-6
        head = cq.Solid.makeCylinder(bolt, bolt, cq.Vector(x, start - bolt, z), up)
        assert upper.intersect(head).Volume() < 1e-6


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"encoder": EncoderDimensions(bolt_circle=20.0)}, r"hip\.encoder\.bolt_circle = 20: allowed is at least 26.4"),
        ({"encoder": EncoderDimensions(bolt_count=2.5)}, r"hip\.encoder\.bolt_count = 2.5: allowed is a whole number"),
        ({"damper": DamperDimensions(bolt_count=4.5)}, r"hip\.damper\.bolt_count = 4.5: allowed is a whole number"),
        (
            {"damper": DamperDimensions(20.0, 12.0, 30.0, 12, 8.0)},
            r"hip\.damper\.bolt_circle = 30: allowed is at least 34\.78 mm; 12 screws fit on it with 1 mm between",
        ),
        (
            {"damper": DamperDimensions(40.0, 12.0, 47.0, 4, 3.4), "clearance": 1.8},
            r"hip\.damper\.bolt_circle = 47: allowed is at least 50 mm; inserts for M3",
        ),
        (
            {"mount": MountDimensions(bolt_diameter=9.0, spacing_along=16.0)},
            r"hip\.mount\.spacing_along = 16: allowed is at least 18 mm with screws of 9 mm",
        ),
        ({"encoder": EncoderDimensions(magnet_diameter=7.5)}, r"hip\.encoder\.magnet_diameter = 7.5"),
        ({"encoder": EncoderDimensions(body_diameter=8.0)}, r"hip\.encoder\.body_diameter = 8.*rim"),
        ({"mount": MountDimensions(spacing_across=20.0)}, r"hip\.mount\.spacing_across = 20.*heads"),
        ({"damper": replace(HIP.damper, outer_diameter=13.0)}, r"hip\.damper\.outer_diameter = 13.*adapter"),
        ({"shaft_diameter": 7.0}, r"hip\.shaft_diameter = 7: allowed is one of 3, 4, 5, 6, 8, 10, 12, 15, 20 mm"),
        (
            {"damper": DamperDimensions(bore=BoreDimensions("star"))},
            r"hip\.damper\.bore\.form = 'star': allowed is round",
        ),
        (
            {"damper": DamperDimensions(bore=BoreDimensions("square", 8.0))},
            r"hip\.damper\.bore\.size = 8.*at most 6\.285",
        ),
        (
            {"damper": DamperDimensions(bore=BoreDimensions("round", 7.0))},
            r"hip\.damper\.bore\.size = 7.*at least 8 mm",
        ),
        (
            {"damper": DamperDimensions(bore=BoreDimensions("round", 8.0, "none"))},
            r"hip\.damper\.bore\.hub = 'none': allowed is set_screw or clamp.*transmits no torque",
        ),
        (
            {"damper": DamperDimensions(bore=BoreDimensions("round", 14.0, "clamp"))},
            r"hip\.damper\.bore\.size = 14.*allowed is 8 mm.*not a printed insert",
        ),
        ({"damper": DamperDimensions(bolt_circle=46.0)}, r"hip\.damper\.bolt_circle = 46.*at least 47.2 mm; inserts"),
        ({"loads": LoadDimensions(spring_rate=-1.0)}, r"hip\.loads\.spring_rate = -1"),
        ({"floor": 0.5}, r"hip\.floor = 0.5"),
    ],
)
def test_an_impossible_fitting_is_refused_by_name(change, named):
    with pytest.raises(DimensionError, match=named):
        lay_out(replace(HIP, **change))


@pytest.mark.parametrize("form", ["d", "square"])
def test_the_least_bore_for_an_insert_prints(form):
    """At a D's flat the insert was 0.9 mm thick: its wall was that of half its size, and only its print was refused."""
    damper = DamperDimensions(bore=BoreDimensions(form, 11.0))
    with pytest.raises(DimensionError, match="or another shaft_diameter than 8 mm") as caught:
        lay_out(replace(HIP, damper=damper))
    (problem,) = caught.value.problems
    least = float(problem.allowed.split("at least ")[1].split()[0])
    damper = replace(damper, bore=BoreDimensions(form, least + 0.01))
    joint = build_joint(cleared(replace(HIP, damper=damper, encoder=None)))
    found = [check for check in check_printing(joint, PrintDimensions()) if check.part == "hip_damper_insert"]
    assert [str(check) for check in found if not check.passed] == []


def test_only_the_first_joint_has_a_mount():
    with pytest.raises(DimensionError, match=r"knee\.mount.*first joint"):
        build_leg(LegDimensions("two", (HIP, replace(HIP, name="knee"))))


def test_a_damper_too_large_for_the_link_is_named():
    damper = DamperDimensions(140.0, 16.0, 150.0)
    plain = cleared(replace(HIP, damper=damper, mount=None, encoder=None, link_length=200.0))
    with pytest.raises(DimensionError, match=r"damper\.bolt_circle = 150.*too wide for the link of 200 mm"):
        build_leg(LegDimensions("two", (plain, replace(plain, name="knee"))))


def test_exchange_files_contain_the_built_parts(hip, tmp_path):
    import xml.etree.ElementTree as ET
    import zipfile

    import ezdxf
    import numpy as np
    import trimesh

    files = export_leg(hip, tmp_path, checks=(), pictures=False)
    assert {file.kind for file in files} == {"step", "stl", "3mf", "glb", "dxf"}
    printed = {part.name: part for part in hip.parts if part.printed}
    model = ET.fromstring(zipfile.ZipFile(tmp_path / "leg_print_1.3mf").read("3D/3dmodel.model"))
    space = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.get("unit") == "millimeter"
    found = {item.get("name"): item for item in model.iterfind(".//m:object", space)}
    assert found.keys() == printed.keys()
    for name, item in found.items():
        points = np.array([[float(v.get(k)) for k in "xyz"] for v in item.iterfind(".//m:vertex", space)])
        faces = np.array([[int(t.get(k)) for k in ("v1", "v2", "v3")] for t in item.iterfind(".//m:triangle", space)])
        body = trimesh.Trimesh(points, faces, process=False)
        assert body.is_watertight
        assert body.volume == pytest.approx(printed[name].solid.Volume(), rel=5e-3)
        assert points[:, 2].min() == pytest.approx(0.0, abs=1e-4)  # it lies on the bed
    assert len(model.findall(".//m:item", space)) == len(printed)

    scene = trimesh.load_scene(tmp_path / "leg.glb")
    assert set(scene.geometry) == {part.name for part in hip.parts}
    height = np.ptp(scene.bounds[:, 1])
    assert 0.1 < height < 0.5  # metres

    sheet = ezdxf.readfile(tmp_path / "hip_damper_bracket_sheet.dxf")
    circles = [entity for entity in sheet.modelspace() if entity.dxftype() == "CIRCLE"]
    radii = sorted(round(circle.dxf.radius, 3) for circle in circles)
    layout = hip.joints[0].layout
    assert radii == sorted([1.7] * 4 + [round(layout.bracket_bore, 3), round(layout.bracket_radius, 3)])
    assert sheet.units == ezdxf.units.MM
    before = {name: (tmp_path / name).read_bytes() for name in ("leg_print_1.3mf", "leg.glb", "hip_mount.dxf")}
    export_leg(hip, tmp_path / "again", checks=(), pictures=False)
    assert {name: (tmp_path / "again" / name).read_bytes() for name in before} == before


def red_pixels(pixels):
    return int(((pixels[..., 0] > 0.6) & (pixels[..., 1] < 0.3) & (pixels[..., 2] < 0.3)).sum())


def test_thin_walls_are_marked_in_red(hip, tmp_path):
    """The marks were black: each was smaller than the edges that were drawn around it."""
    from matplotlib.image import imread

    from synth.cad import PreviewError, draw_failures

    lower = hip.joints[0].part("lower")
    some = float(np.percentile(wall_thickness(lower.mesh)[1], 1.5))  # mm, so that 1.5 % of the points are marked
    asked = replace(hip.dimensions, printing=PrintDimensions(thinnest=some))
    leg, found = replace(hip, dimensions=asked), check_printing(hip.joints[0], asked.printing)
    failed = [c for c in found if c.name == "print: wall" and c.part == lower.name and not c.passed]
    assert failed
    try:
        written = draw_failures(leg, failed, tmp_path)
    except PreviewError as error:
        pytest.skip(str(error))
    assert min(red_pixels(imread(tmp_path / name)[..., :3]) for name in written) > 100


def test_a_failure_is_drawn_in_red(hip, tmp_path):
    from matplotlib.image import imread

    from synth.cad import PreviewError, draw_failures

    joint = hip.joints[0]
    wider = replace(joint.dimensions, range=(60.0, 140.0))
    leg = replace(hip, joints=(replace(joint, dimensions=wider),))
    failed = [check for check in check_travel(Bodies(leg.joints[0])) if not check.passed]
    assert [check.name for check in failed] == ["stops"]
    try:
        written = draw_failures(leg, failed, tmp_path)
    except PreviewError as error:
        pytest.skip(str(error))
    assert len(written) == len(failed)
    for name in written:
        pixels = imread(tmp_path / name)[..., :3]
        assert red_pixels(pixels) > 50
