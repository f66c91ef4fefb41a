"""The leg file: all mistakes at once with their lines; what is written reads back the same."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from synth.errors import Problem, UserError
from synth.files.leg_file import read_leg, write_leg
from synth.files.names import file_name, name_fault
from synth.swing.effects import registered
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

SHARED = Path(__file__).parents[3] / "shared"
LINK = "{length: 200 mm, mass: 0.74 kg, com: 91 mm, inertia: 3.5e-3 kg*m^2}"
JOINT = f"  - name: hip\n    zero: 90 deg\n    sign: +1\n    link: {LINK}\n"


def written(tmp_path: Path, joint: str, head: str = "") -> Path:
    path = tmp_path / "x.leg.yaml"
    path.write_text(f"kind: leg\nname: x\n{head}joints:\n{JOINT}{joint}")
    return path


def problems(tmp_path: Path, joint: str, head: str = "") -> list[Problem]:
    with pytest.raises(UserError) as caught:
        read_leg(written(tmp_path, joint, head))
    return caught.value.problems


def test_reads_the_example_of_the_format(tmp_path: Path) -> None:
    path = tmp_path / "dog.leg.yaml"
    path.write_text(
        """kind: leg
name: dog hind leg
gravity: 9.81 m/s^2
tilt: 5 deg                 # rotation of the whole base
joints:
  - name: hip
    zero: 90 deg
    sign: -1
    range: [60 deg, 150 deg]
    link: {length: 200 mm, mass: 0.74 kg, com: 91 mm, inertia: 3.5e-3 kg*m^2}
    spring: {rate: 0.39 N*m/deg, free_angle: 105 deg}
    damper: {rate: 1.29 N*m*s/rad}
    effects:
      - coulomb_friction: {torque: 0.05 N*m}
"""
    )
    leg = read_leg(path)
    hip = leg.joints[0]
    assert (leg.name, leg.joint_names, hip.sign) == ("dog hind leg", ("hip",), -1)
    assert leg.tilt == pytest.approx(math.radians(5))
    assert hip.range == pytest.approx((math.radians(60), math.radians(150)))
    assert hip.link == Link(0.2, 0.74, pytest.approx(0.091), pytest.approx(3.5e-3))
    assert hip.spring == Spring(pytest.approx(0.39 * 180 / math.pi), pytest.approx(math.radians(105)))
    assert hip.damper == Damper(rate=pytest.approx(1.29))
    assert hip.effects == {"coulomb_friction": {"torque": pytest.approx(0.05)}}


def test_every_mistake_at_once_in_the_order_of_lines(tmp_path: Path) -> None:
    path = tmp_path / "x.leg.yaml"
    path.write_text(
        f"""kind: leg
name: x
gravity: 9.81
joints:
  - name: hip
    zero: 90 deg
    sgn: +1
    link: {{length: 200 mm, mass: -0.74 kg, com: 91 mm, inertia: 3.5e-3 kg*m}}
  - name: knee
    zero: 90 deg
    sign: 2
    link: {LINK}
    spring: {{rate: 23 N*m, free_angel: 5 deg}}
    damper: {{rate: 1 N*m*s/rad, curve: x.csv}}
    effects:
      - coulom_friction: {{torque: 1 N*m}}
tild: 5 deg
"""
    )
    with pytest.raises(UserError) as caught:
        read_leg(path)
    found = [(p.line, p.key) for p in caught.value.problems]
    assert found == [
        (3, "gravity"),
        (5, "joints.hip.sign"),
        (7, "joints.hip.sgn"),
        (8, "joints.hip.link.mass"),
        (8, "joints.hip.link.inertia"),
        (11, "joints.knee.sign"),
        (13, "joints.knee.spring.rate"),
        (13, "joints.knee.spring.free_angle"),
        (13, "joints.knee.spring.free_angel"),
        (14, "joints.knee.damper"),
        (16, "joints.knee.effects[1].coulom_friction"),
        (17, "tild"),
    ]
    text = str(caught.value)
    for near in ("did you mean sign?", "did you mean free_angle?", "did you mean coulomb_friction?", "mean tilt?"):
        assert near in text
    assert all(problem.file == str(path) for problem in caught.value.problems)


@pytest.mark.parametrize(
    ("joint", "key", "words"),
    [
        ("    range: [150 deg, 60 deg]\n", "joints.hip.range", "smaller angle"),
        ("    range: [150 deg]\n", "joints.hip.range", "2 are needed"),
        ("    range: [60 deg, 50000 deg]\n", "joints.hip.range[2]", "at most 36000 deg"),
        ("    spring: {rate: 5 N*m/rad, free_angle: 800 deg}\n", "joints.hip.spring.free_angle", "at most 720 deg"),
        ("    spring: {rate: -5 N*m/rad, free_angle: 80 deg}\n", "joints.hip.spring.rate", "at least 0"),
        ("    spring: {free_angle: 80 deg}\n", "joints.hip.spring", "rate"),
        ("    spring: {part: X1, free_angle: 80 deg}\n", "joints.hip.spring.part", "no catalogue is available"),
        ("    damper: {part: X1}\n", "joints.hip.damper.part", "no catalogue is available"),
        ("    damper: {}\n", "joints.hip.damper", "curve"),
        ("    damper: {curve: none.csv}\n", "joints.hip.damper.curve", "does not exist"),
        ("    damper: {curve: ../none.csv}\n", "joints.hip.damper.curve", "leads out"),
        ("    damper: {curve: /etc/passwd}\n", "joints.hip.damper.curve", "absolute"),
        ("    damper: 5\n", "joints.hip.damper", "mapping"),
        ("    effects: [coulomb_friction: {}]\n", "joints.hip.effects[1].coulomb_friction", '"torque" is missing'),
        ("    effects: [coulomb_friction: {torque: 1 N}]\n", "joints.hip.effects[1].coulomb_friction.torque", "force"),
        ("    effects: {coulomb_friction: {torque: 1 N*m}}\n", "joints.hip.effects", "list"),
        (JOINT, "joints.hip.name", "used twice (first in line 4)"),
        (JOINT.replace("hip", "a,b"), "joints.a,b.name", "cannot be a joint's name"),
        (JOINT.replace("hip", "time"), "joints.time.name", "another meaning"),
        (JOINT.replace("hip", "k").replace("91 mm", "9.1 m"), "joints.k.link.com", "45.5 lengths"),
        ("".join(JOINT.replace("hip", f"j{i}") for i in range(6)), "joints", "no more than 6"),
        ("  - 5\n", "joints[2]", "mapping"),
    ],
)
def test_a_single_mistake_is_reported_with_its_line(tmp_path: Path, joint: str, key: str, words: str) -> None:
    found = problems(tmp_path, joint)
    assert [p.key for p in found] == [key]
    assert words in found[0].text


def test_negative_centre_of_mass_is_allowed(tmp_path: Path) -> None:
    path = written(tmp_path, JOINT.replace("hip", "knee").replace("com: 91 mm", "com: -20 mm"))
    assert read_leg(path).joints[1].link.com == pytest.approx(-0.02)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("kind: fit", "leg file"), ("kind: legg", "did you mean leg"), ("title: x", '"kind" is missing')],
)
def test_wrong_kind(tmp_path: Path, kind: str, words: str) -> None:
    path = tmp_path / "x.yaml"
    path.write_text(f"{kind}\nname: x\n")
    with pytest.raises(UserError, match=words):
        read_leg(path)


def test_parts_come_from_the_catalogue(tmp_path: Path) -> None:
    path = written(tmp_path, "    spring: {part: S1, free_angle: 80 deg}\n    damper: {part: D1}\n")
    damper = Damper(rate=0.5, part="D1")

    def resolve(kind: str, part: str) -> float | Damper:
        if part == "S1" and kind == "spring":
            return 2.25
        if part == "D1" and kind == "damper":
            return damper
        raise UserError(f"no {kind} {part}")

    joint = read_leg(path, resolve_part=resolve).joints[0]
    assert joint.spring == Spring(2.25, pytest.approx(math.radians(80)), "S1")
    assert joint.damper == damper
    bad = written(tmp_path, "    spring: {part: S2, free_angle: 80 deg}\n    damper: {part: D2}\n")
    with pytest.raises(UserError) as caught:
        read_leg(bad, resolve_part=resolve)
    assert [(p.line, p.text) for p in caught.value.problems] == [(8, "no spring S2"), (9, "no damper D2")]


def test_curve_in_other_units(tmp_path: Path) -> None:
    (tmp_path / "c.csv").write_text("torque [ozf*in],speed [rpm]\n0,0\n7,25\n31,50\n")
    curve = read_leg(written(tmp_path, "    damper: {curve: c.csv}\n")).joints[0].damper.curve
    assert curve.speed == pytest.approx((25 * math.pi / 30, 50 * math.pi / 30))
    assert curve.torque == pytest.approx((7 * 7.061552e-3, 31 * 7.061552e-3), rel=1e-6)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("speed [rpm],torque [N*m]\n10,1\n10,2\n", 3, "increase"),
        ("speed [rpm],torque [N*m]\n-10,1\n10,2\n", 2, "negative"),
        ("speed [rpm],torque [N*m]\n10,-1\n", 2, "negative"),
        ("speed [rpm],torque [N*m]\n0,1\n10,2\n", 2, "coulomb_friction"),
        ("speed [rpm],torque [N*m]\n0,0\n", None, "above zero"),
        ("speed [rpm],torque [N*m]\n10,\n", 2, "empty cell"),
        ("speed [mm],torque [N*m]\n10,1\n", 1, "angular speed"),
        ("sped [rpm],torque [N*m]\n10,1\n", 1, "did you mean speed"),
        ("speed,torque\n10,1\n", 1, "no unit"),
        ("speed [rpm],torque [N*m]\n", None, "no rows"),
    ],
)
def test_bad_curve(tmp_path: Path, text: str, line: int | None, words: str) -> None:
    (tmp_path / "c.csv").write_text(text)
    found = problems(tmp_path, "    damper: {curve: c.csv}\n")
    assert (found[0].file, found[0].line) == (str(tmp_path / "c.csv"), line)
    assert words in found[0].text


def test_a_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out.csv").write_text("speed [rpm],torque [N*m]\n10,1\n")
    inner = tmp_path / "project"
    inner.mkdir()
    (inner / "c.csv").symlink_to(tmp_path / "out.csv")
    assert "by a link" in problems(inner, "    damper: {curve: c.csv}\n")[0].text


angles = st.floats(-6.0, 6.0)
sizes = st.floats(1e-6, 1e3)
springs = st.none() | st.builds(Spring, sizes, angles, st.none() | st.just("LTR135H 10 M"))
curves = st.lists(sizes, min_size=1, max_size=5, unique=True).map(
    lambda speeds: DamperCurve(tuple(sorted(speeds)), tuple(0.1 * s for s in sorted(speeds)))
)
ONE_JOINT = """
kind: leg
name: one
gravity: 9.81 m/s^2
joints:
  - name: hip
    zero: 90 deg
    sign: +1
    link: {length: 222 mm, mass: 222 g, com: 80 mm, inertia: 0.0011251 kg*m^2}
    spring: {rate: 2 N*m/rad, free_angle: 0 deg}
"""
dampers = st.none() | st.builds(Damper, rate=sizes) | st.builds(Damper, curve=curves, part=st.just("6597K21"))
links = st.tuples(st.floats(0.1, 2.0), sizes, st.floats(-0.4, 0.4), st.floats(0.01, 4.0), st.floats(-0.4, 0.4)).map(
    # the fourth: of gyration, in lengths
    lambda drawn: Link(*drawn[:3], drawn[1] * (drawn[0] * drawn[3]) ** 2, com_across=drawn[4])
)
effects = st.sampled_from(
    [
        {},
        {"coulomb_friction": {"torque": 1 / 3, "presliding": 0.01}},
        {"joint_stop": {"upper": 1.0, "stiffness": 50.0}, "latency": {"delay": 1e-3}},
        {"link_flexibility": {"stiffness": 70.0}, "encoder_offset": {"offset": -0.02}},
    ]
)
base_effects = st.sampled_from([{}, {"base_compliance": {"rocking_stiffness": 300.0}}])


@pytest.mark.parametrize(
    ("effect", "wanted"),
    [
        (
            "coulomb_friction: {torque: -0.1 N*m}",
            "coulomb_friction.torque: -0.1 N*m is not allowed: it must be at least 0",
        ),
        ("latency: {delay: -5 ms}", "latency.delay: -5 ms is not allowed: it must be at least 0"),
        ("link_flexibility: {stiffness: 0 N*m/rad}", "it must be more than 0"),
        ("link_flexibility: {stiffness: 70 N*m/rad, place: 1}", "place: 1 is not allowed: it must be less than 1"),
        ("link_flexibility: {stiffness: 70 N*m/rad, damping_ratio: -0.1}", "it must be at least 0"),
        (
            "stribeck_friction: {torque: 0.1 N*m, speed: 0 rad/s}",
            "speed: 0 rad/s is not allowed: it must be more than 0",
        ),
        ("quadratic_damping: {coefficient: 1 N*m*s^2/rad^2, speed: -1 rad/s}", "it must be more than 0"),
        (
            "spring_rate: {rate: 1 N*m/rad}",
            '"spring_rate" is no effect that a joint can hold; change `rate` and `free_angle` of `spring:` instead: '
            "this effect is another value of that",
        ),
        ("base_compliance: {horizontal: 1 N/m}", "can hold; write it in `effects:` beside `joints:`"),
        ("coulomb_frictoin: {torque: 1 N*m}", "point synth.effects); did you mean coulomb_friction?"),
    ],
)
def test_an_effect_that_cannot_be_is_refused(effect: str, wanted: str, tmp_path: Path) -> None:
    """A dry friction below zero would drive the joint."""
    (tmp_path / "x.leg.yaml").write_text(ONE_JOINT + f"    effects: [{{{effect}}}]\n", encoding="utf-8")
    with pytest.raises(UserError) as refused:
        read_leg(tmp_path / "x.leg.yaml")
    (problem,) = refused.value.problems
    assert str(problem).endswith(wanted)


def test_every_effect_that_changes_a_number_says_which() -> None:
    for effect in registered():
        assert bool(effect.changes) is (effect.way == "leg"), effect.name


@pytest.mark.parametrize(
    "effect",
    [
        "coulomb_friction: {torque: 0 N*m, presliding: 0 deg}",
        "hardening_spring: {stiffening: -0.1 N*m}",
        "link_flexibility: {stiffness: 70 N*m/rad, place: 0.9, damping_ratio: 0}",
        "joint_stop: {lower: -20 deg, stiffness: 5 N*m/rad}",
    ],
)
def test_an_effect_that_can_be_is_read(effect: str, tmp_path: Path) -> None:
    (tmp_path / "x.leg.yaml").write_text(ONE_JOINT + f"    effects: [{{{effect}}}]\n", encoding="utf-8")
    assert list(read_leg(tmp_path / "x.leg.yaml").joints[0].effects) == [effect.partition(":")[0]]


@st.composite
def legs(draw: st.DrawFn) -> Leg:
    names = draw(
        st.lists(
            st.text("abc XY-_é1.", min_size=1, max_size=8).filter(lambda name: name_fault(name) is None),
            min_size=1,
            max_size=6,
            unique_by=lambda name: file_name(name).casefold(),
        )
    )
    joints = [
        Joint(
            name,
            draw(links),
            draw(angles),
            draw(st.sampled_from([1, -1])),
            draw(st.sampled_from([None, (-1.0, 0.3)])),
            draw(springs),
            draw(dampers),
            draw(effects),
        )
        for name in names
    ]
    name = draw(st.sampled_from(["x", "Hüfte: 'a' #1", "yes", "12"]))
    return Leg(name, tuple(joints), draw(sizes), draw(angles), draw(base_effects))


TWIN = DamperCurve((1.0,), (0.1,)), DamperCurve((2.0,), (0.2,))


@example(Leg("x", tuple(Joint(n, Link(1, 1, 0, 1), damper=Damper(curve=c)) for n, c in zip("_é", TWIN, strict=True))))
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(legs())
def test_written_leg_reads_back(tmp_path: Path, leg: Leg) -> None:
    path = tmp_path / "round.leg.yaml"
    write_leg(leg, path)
    again = read_leg(path)
    assert (again.name, again.joint_names) == (leg.name, leg.joint_names)
    assert [again.gravity, again.tilt] == pytest.approx([leg.gravity, leg.tilt], rel=1e-12, abs=1e-300)
    for old, new in zip(leg.joints, again.joints, strict=True):
        for name in ("length", "mass", "com", "inertia"):
            assert getattr(new.link, name) == pytest.approx(getattr(old.link, name), rel=1e-12, abs=1e-300)
        assert (new.sign, new.range is None) == (old.sign, old.range is None)
        assert new.zero == pytest.approx(old.zero, rel=1e-12, abs=1e-300)
        assert (new.spring is None, new.damper is None) == (old.spring is None, old.damper is None)
        if old.spring is not None:
            assert new.spring.rate == pytest.approx(old.spring.rate, rel=1e-12)
            assert new.spring.free_angle == pytest.approx(old.spring.free_angle, rel=1e-12, abs=1e-300)
            assert new.spring.part == old.spring.part
        if old.damper is not None and old.damper.curve is not None:
            assert new.damper == old.damper
        elif old.damper is not None:
            assert new.damper.rate == pytest.approx(old.damper.rate, rel=1e-12)
        assert dict(new.effects) == {name: pytest.approx(values) for name, values in old.effects.items()}
    assert dict(again.effects) == {name: pytest.approx(values) for name, values in leg.effects.items()}
    first = path.read_bytes()
    write_leg(again, path)
    assert path.read_bytes() == first


@pytest.mark.skipif(not SHARED.is_dir(), reason="the lab's data lie outside the repository")
def test_real_legs() -> None:
    paths = [*SHARED.glob("aarl/*/*.leg.yaml"), *SHARED.glob("cases/*/*/*.leg.yaml")]
    assert len(paths) >= 14
    assert {len(read_leg(path).joints) for path in paths} == {2, 3}
