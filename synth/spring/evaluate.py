"""Evaluation of one torsion spring against its requirements: rate, stress, travel before yield, room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from synth.errors import UserError
from synth.parts import coil_angle
from synth.parts.coil_rate import RATE_FORMULA, RateForm, active_coils, energy, rate
from synth.parts.wire import WireMaterial, WireProperties
from synth.spring import arms, codes, fatigue, space, stress, winding
from synth.spring.sizes_alone import SLACK, room_of
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign
from synth.spring.spring_task import SpringLimits, SpringTask, Violation
from synth.spring.unit_text import MeasuredText, UnitText
from synth.spring.wire_load import PeakRatios, WireLoad

LASTING_ROUNDS = 4  # of a lasting travel with clamped arms: a tenth of a degree, to which it is rounded


def check_spring(
    material: WireMaterial,
    wire_diameter: float,
    mean_diameter: float,
    body_coils: float,
    task: SpringTask,
    *,
    included_angle: float | None = None,
    stated_rate: float | None = None,
    count: int = 1,
) -> SpringDesign:
    """Evaluate a given spring.

    Parameters
    ----------
    material
        wire material, from ``Catalogue.find_material``.
    wire_diameter, mean_diameter
        m.
    body_coils
        number of coils of the body.
    task
        travel, legs and limits.
    included_angle
        rad, if stated; one that contradicts the coils is a violation. Default: the angle that the coils give.
    stated_rate
        N m/rad, published or measured; moments are computed with it. Default: that of the task's formula including the
        legs, times the factor of its calibration.
    count
        number of equal springs in parallel.

    Raises
    ------
    UserError
        If the modulus, strength, yield or density of this wire is unknown, or a size is impossible.
    """
    if not (wire_diameter > 0.0 and mean_diameter > wire_diameter and body_coils > 0.0):
        raise UserError(
            f"no coil can have wire {wire_diameter * 1e3:.4g} mm, mean diameter {mean_diameter * 1e3:.4g} mm and "
            f"{body_coils:.4g} coils: the mean diameter must be above the wire's and the coils above 0"
        )
    angle = coil_angle.included_angle(body_coils, task.convention) if included_angle is None else included_angle
    coil = _Coil(wire_diameter, mean_diameter, body_coils, angle, count)
    design = _evaluate_coil(material, coil, task, _load_coil(material, coil, task, stated_rate))
    violations = tuple(broken_limits(design, task.limits))
    return replace(design, violations=violations) if violations else design


def kept_spring(
    material: WireMaterial, sizes: tuple[float, float, float], task: SpringTask, *, lasting: bool = False
) -> SpringDesign | None:
    """``check_spring`` of a spring that keeps all limits, else None; ``lasting``: and that lasts.

    Most candidates of a search are too weak or too short-lived, which their stresses alone tell: a third of the time.
    """
    coil = _Coil(*sizes, coil_angle.included_angle(sizes[2], task.convention), 1)
    loaded = _load_coil(material, coil, task, None)
    wire, limits = loaded.wire, task.limits
    if loaded.bears.winding_stress > wire.static_limit * wire.strength.value / limits.safety * (1.0 + SLACK):
        return None
    if lasting and not lasts(loaded.life, limits):
        return None
    design = _evaluate_coil(material, coil, task, loaded)
    return None if any(broken_limits(design, limits)) else design


def lasts(life: fatigue.Life | None, limits: SpringLimits) -> bool:
    """Whether a life reaches the required number of full-travel cycles, or ``DESIGN_LIFE`` if none is required."""
    cycles = DESIGN_LIFE if limits.cycles is None else limits.cycles
    return life is not None and life.factor(cycles) >= limits.fatigue_safety


@dataclass(frozen=True)
class _Coil:
    """The sizes of a spring, as in ``check_spring``."""

    wire_diameter: float
    mean_diameter: float
    body_coils: float
    included_angle: float
    count: int


@dataclass(frozen=True)
class _Borne:
    """What the wire bears at the ends of both travels, winding and opening.

    Stresses (Pa) in the coil and where an arm leaves it, and the largest moment in the coil (N m).
    """

    arm: float | None
    peaks: tuple[PeakRatios, PeakRatios]
    winding_stress: float
    opening_stress: float
    arm_stresses: tuple[float, float]
    in_coil: float


def _borne(coil: _Coil, task: SpringTask, used: float) -> _Borne:
    """The load of a coil with the rate ``used``, N m/rad."""
    bend = _bend_radius(task, coil.wire_diameter) or coil.wire_diameter
    sizes = (coil.wire_diameter, coil.mean_diameter, coil.body_coils)
    load = WireLoad(used, *sizes, None if task.free_arm is None else task.free_arm(*sizes))
    winding, opening = load.ratios(task.travel), load.ratios(-task.opening_travel)
    lever = arms.lever_of(task.convention, task.leg_lengths, coil.mean_diameter)
    return _Borne(
        load.arm,
        (winding, opening),
        load.stress(task.travel, winding),
        load.stress(-task.opening_travel, opening),
        (
            arms.arm_stress(used * task.travel * winding.arms, coil.wire_diameter, task.convention, bend, lever),
            arms.arm_stress(
                used * task.opening_travel * opening.arms, coil.wire_diameter, task.convention, bend, lever
            ),
        ),
        used * max(task.travel * winding.coil, task.opening_travel * opening.coil),
    )


def _bend_radius(task: SpringTask, wire_diameter: float) -> float | None:
    """Inside radius of the arms' bends, m; None for tangent arms, which have none."""
    return None if task.convention == "tangent" else (task.limits.bend_radius or wire_diameter)


@dataclass(frozen=True)
class _LoadedCoil:
    """A coil's wire, active coils, rates by formula, rate that is used, load and life."""

    wire: WireProperties
    active: float
    forms: Mapping[RateForm, float]
    used: float
    bears: _Borne
    life: fatigue.Life | None


def _load_coil(material: WireMaterial, coil: _Coil, task: SpringTask, stated_rate: float | None) -> _LoadedCoil:
    wire = material.properties(coil.wire_diameter)
    active = active_coils(coil.body_coils, coil.mean_diameter, task.leg_lengths, task.convention)
    sizes = (coil.wire_diameter, coil.mean_diameter, active)
    forms = {form: rate(wire.elastic_modulus, *sizes, form) for form in RATE_FORMULA}
    used = forms[task.rate_form] * task.calibration.rate if stated_rate is None else stated_rate
    bears = _borne(coil, task, used)
    return _LoadedCoil(wire, active, forms, used, bears, _life(wire, bears, task))


def _evaluate_coil(material: WireMaterial, coil: _Coil, task: SpringTask, loaded: _LoadedCoil) -> SpringDesign:
    """Rate, stress, room and life of a coil, without the comparison with its limits."""
    wire, forms, used, bears = loaded.wire, loaded.forms, loaded.used, loaded.bears
    d, mean, body_coils, travel = coil.wire_diameter, coil.mean_diameter, coil.body_coils, task.travel
    yield_stress, room = wire.static_limit * wire.strength.value, room_of(material, (d, mean, body_coils), task)
    return SpringDesign(
        material=material.name,
        wire_diameter=d,
        mean_diameter=mean,
        body_coils=body_coils,
        active_coils=loaded.active,
        included_angle=coil.included_angle,
        convention=task.convention,
        leg_lengths=task.leg_lengths,
        elastic_modulus=wire.elastic_modulus,
        rate=used,
        rate_bending_form=forms["bending"],
        rate_friction_form=forms["friction"],
        index=stress.spring_index(mean, d),
        curvature_factor=stress.curvature_factor(mean / d),
        tensile_strength=wire.strength.value,
        strength_basis=wire.strength.basis,
        strength_source=wire.strength.source,
        yield_stress=yield_stress,
        yield_source=wire.static_source,
        allowed_stress=yield_stress / task.limits.safety,
        travel=travel,
        opening_travel=task.opening_travel,
        moment=used * travel,
        stress=bears.winding_stress,
        body_length=space.body_length(d, body_coils, pitch=task.pitch),
        wound_body_length=room.wound_body_length,
        widest_outer_diameter=room.widest_outer_diameter,
        inside_diameter=mean - d,
        wound_inside_diameter=space.wound_inside_diameter(d, mean, body_coils, travel),
        arbor_diameter=task.limits.arbor_diameter,
        wire_length=room.wire_length,
        mass=room.mass,
        energy=energy(used * max(travel, task.opening_travel), used),
        tolerance=winding.winding_tolerance(d, mean, body_coils, wire.diameter_tolerance),
        life=loaded.life,
        arm_stress=max(bears.arm_stresses),
        bend_radius=_bend_radius(task, d),
        opening_stress=bears.opening_stress,
        allowed_opening_stress=codes.OPENING * yield_stress / task.limits.safety,
        surge_frequency=codes.surge_frequency(d, mean, body_coils, wire.elastic_modulus, wire.density),
        codes=codes.code_checks(wire.allowables, bears.in_coil, d, mean),
        rate_form=task.rate_form,
        rate_factor=task.calibration.rate,
        spring_back=task.calibration.spring_back,
        count=coil.count,
        hand=task.hand,
        clamped_arm=bears.arm,
        peaks=bears.peaks,
        pitch=task.pitch,
    )


def _life(wire: WireProperties, bears: _Borne, task: SpringTask) -> fatigue.Life | None:
    """Life of the coil, or of the arms' bends where that is shorter."""
    stresses = [(bears.winding_stress, bears.opening_stress)]
    if task.convention != "tangent":
        stresses.append(bears.arm_stresses)
    lives = [fatigue.life(wire.fatigue, wire.strength.value, -opening, winding) for winding, opening in stresses]
    known = [life for life in lives if life is not None]
    return min(known, key=lambda life: life.factor_1e6, default=None)


def broken_limits(design: SpringDesign, limits: SpringLimits) -> Iterator[Violation]:
    """The limits that a spring violates, each with its numbers."""

    def text(what: str, value: float, relation: str, limit: float, si: str) -> UnitText:
        found, bound = MeasuredText(value, si, beside=limit), MeasuredText(limit, si, beside=value)
        return UnitText(f"{what} ", found, f", {relation} ", bound)

    def above(name: str, value: float, limit: float | None, what: str, si: str = "m") -> Iterator[Violation]:
        if limit is not None and value > limit * (1.0 + SLACK):
            yield Violation(name, value / limit, text(what, value, "allowed", limit, si))

    def below(name: str, value: float, limit: float | None, what: str, si: str = "m") -> Iterator[Violation]:
        if limit is not None and value < limit * (1.0 - SLACK):
            excess = limit / value if value > 0.0 else math.inf
            yield Violation(name, excess, text(what, value, "required", limit, si))

    yield from above("stress", design.stress, design.allowed_stress, "stress at full travel", "Pa")
    opened, less = design.opening_stress, design.allowed_opening_stress
    yield from above("stress", opened, less, "stress at the opening travel", "Pa")
    if design.bend_radius is not None:  # a straight arm has less stress than the coil
        yield from above("arms", design.arm_stress, design.allowed_stress, "stress in the arms' bends", "Pa")
    if limits.cycles is not None:
        if design.life is None:
            yield Violation("fatigue", math.inf, f"no fatigue data are known for {design.material} wire")
        else:
            factor = design.life.factor(limits.cycles)
            shown = f"strength over stress for {limits.cycles:.0g} cycles"
            yield from below("fatigue", factor, limits.fatigue_safety, shown, "1")
    yield from above("outer_diameter", design.widest_outer_diameter, limits.max_outer_diameter, "outer diameter")
    yield from below("inside_diameter", design.inside_diameter, limits.min_inside_diameter, "inside diameter")
    free = design.inside_diameter + 2.0 * design.wire_diameter
    yield from below("least_outer_diameter", free, limits.min_outer_diameter, "outer diameter")
    yield from below("least_body_length", design.body_length, limits.min_body_length, "body length")
    wound = design.wound_inside_diameter
    yield from below("arbor", wound, limits.least_wound_inside(), "inside diameter at full travel")
    yield from above("body_length", design.wound_body_length, limits.max_body_length, "body length at full travel")
    yield from below("index", design.index, limits.index_range[0], "spring index", "1")
    yield from above("index", design.index, limits.index_range[1], "spring index", "1")
    yield from below("coils", design.body_coils, limits.min_coils, "body coils", "1")
    yield from above("coils", design.body_coils, limits.max_coils, "body coils", "1")
    mismatch = coil_angle.angle_mismatch(design.body_coils, design.included_angle, design.convention)
    if abs(mismatch) > coil_angle.TOLERANCE:
        given = math.degrees(coil_angle.included_angle(design.body_coils, design.convention))
        stated = math.degrees(design.included_angle)
        coils = f"{design.body_coils:.4g} coils with {design.convention} legs"
        contradiction = f"included angle {stated:.4g} deg, but {coils} give {given:.4g} deg"
        yield Violation("included_angle", math.inf, contradiction)


def _lasting_travel(design: SpringDesign, cycles: float, factor: float) -> float:
    """Winding travel (rad) that the spring bears for ``cycles`` cycles with fatigue safety ``factor``.

    The opening travel is that of the design, but not more than the winding travel. By bisection with stresses in
    proportion to the angle; with clamped arms again with those at the angles found.
    """
    assert design.life is not None
    known, load = design.life, design.load
    found, peaks = design.travel, design.peaks
    for _ in range(1 if load.arm is None else LASTING_ROUNDS):
        places = [(load.stress(1.0, peaks[0]), load.stress(1.0, peaks[1]))]
        if design.bend_radius is not None:
            places.append((_in_bend(design, peaks[0]), _in_bend(design, peaks[1])))
        found = min(_borne_travel(design, known.repeated(cycles), factor, per_angle) for per_angle in places)
        peaks = load.ratios(found), load.ratios(-min(design.opening_travel, found))
    return found


def _in_bend(design: SpringDesign, peak: PeakRatios) -> float:
    """Stress in the bend of an arm per angle, Pa/rad."""
    assert design.bend_radius is not None
    lever = arms.lever_of(design.convention, design.leg_lengths, design.mean_diameter)
    return arms.arm_stress(design.rate * peak.arms, design.wire_diameter, design.convention, design.bend_radius, lever)


def _borne_travel(design: SpringDesign, repeated: float, factor: float, per_angle: tuple[float, float]) -> float:
    """As ``_lasting_travel``; ``per_angle``: stress per angle at one place, Pa/rad, winding and opening."""

    def lasts(travel: float) -> bool:
        least = -per_angle[1] * min(design.opening_travel, travel)
        amplitude, mean = (per_angle[0] * travel - least) / 2.0, (per_angle[0] * travel + least) / 2.0
        endurance = fatigue.endurance_about_zero(repeated, design.tensile_strength)
        borne = fatigue.gerber_amplitude(endurance, design.tensile_strength, amplitude, mean)
        return borne >= factor * amplitude

    low, high = 0.0, design.tensile_strength / per_angle[0]
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lasts(middle) else (low, middle)
    return low


def travel_limit(design: SpringDesign, limits: SpringLimits) -> float:
    """The largest winding travel, rad, within the limits on stress, life, arbor and body length; negative if none is.

    Limits that do not depend on the travel are not checked.
    """
    bounds = [design.load.angle(design.allowed_stress), design.arms_angle(design.allowed_stress)]
    if limits.cycles is not None and design.life is not None:
        bounds.append(_lasting_travel(design, limits.cycles, limits.fatigue_safety))
    inside = limits.least_wound_inside()
    if inside is not None:
        bounds.append(
            space.travel_to_inside_diameter(design.wire_diameter, design.mean_diameter, design.body_coils, inside)
        )
    if limits.max_body_length is not None:
        coil = (design.wire_diameter, design.body_coils)
        bounds.append(space.travel_to_body_length(*coil, limits.max_body_length, design.pitch))
    return min(bounds)
