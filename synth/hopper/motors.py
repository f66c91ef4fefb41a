"""Catalogue rows as motors of a leg; unpublished constants are derived or estimated, and marked as such.

Derived at the rated voltage: R = V/I_stall where none is given; K_e = (V - I_free R)/(G omega_free), equation 5 of
Knaup & Aukes; friction K_e I_free at the rotor, equation 6, all of it independent of speed because one no-load point
does not separate a viscous part; with a ``friction_share`` s below 1 the rest is viscous, b = (1 - s) K_e I_free/(G
omega_free). K_t = T_stall/(G (I_stall - s I_free)): at rest only the dry part is lost. With a given R free speed and
current are still the maker's, but the stall torque is K_t G (V/R - s I_free), not the published one. These are the
motor's own; at another supply V' the free speed is that of K_e i = s K_e I_free + b w with i = (V' - K_e w)/R.

Estimated if neither the row nor the project gives them. Rotor inertia: 1.5e-8 kg m^2 for a motor of 9.5 g (a public
estimate for micro metal motors, marked as one by its author), for others by geometric similarity, inertia as mass to
the power 5/3. Inductance: R times 0.25 ms, the electrical time constant of 1 mH at 4 ohm.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import replace

from synth.errors import UserError
from synth.jump.hopper_leg import Motor, MotorOptions
from synth.parts.rows import GearMotorRow

# Kg m^2 and kg of an N20 motor: a public estimate, marked as such by its author; scaled for other motors
# by mass^(5/3), as for similar bodies of equal density.
ROTOR_INERTIA, ROTOR_MASS = 1.5e-8, 0.0095
OTHER_CURRENTS = "currents are those of "  # begins the remark of a row whose maker states those of another ratio
HARDLY_TURNING = 0.99  # of a voltage, the most that a no-load current takes of it at a tolerance's end
ELECTRICAL_TIME = 0.25e-3  # s, of 1 mH at 4 ohm: an estimate


def motor_of(row: GearMotorRow, options: MotorOptions | None = None) -> Motor:
    """The motor of a complete row at its supply voltage.

    Raises
    ------
    ValueError : the row is not complete.
    UserError : the resistance takes all the voltage at the no-load current, or all the supply at its dry part.
    """
    options = options or MotorOptions()
    known = (row.gear_ratio, row.voltage, row.no_load_speed, row.stall_torque, row.stall_current, row.no_load_current,
             row.mass)  # fmt: skip
    if None in known or not row.complete:
        raise ValueError(f"{row.part}: {row.status}")
    ratio, rated, speed, torque, stall, free, mass = (float(value) for value in known if value is not None)
    given = options.resistance or row.resistance
    resistance = given or rated / stall
    supply, share = options.supply or rated, options.friction_share
    if free * resistance >= rated:
        text = f"{row.part}: with a resistance of {resistance:g} ohm its no-load current of {free:g} A takes all of its"
        raise UserError(f"{text} {rated:g} V; the resistance must be below {rated / free:g} ohm")
    if share * free * resistance >= supply:
        text = f"{row.part}: at {supply:g} V this motor does not turn: its no-load current alone takes"
        raise UserError(f"{text} {share * free * resistance:g} V; the supply must be above that")
    back_emf = (rated - free * resistance) / (ratio * speed)
    constant = torque / (ratio * (stall - share * free))
    friction, viscous = back_emf * free * share, back_emf * free * (1.0 - share) / (speed * ratio)
    no_load = _free_speed(supply, resistance, back_emf, friction / back_emf, viscous / back_emf)
    stalled = supply / resistance
    inertia = options.rotor_inertia or row.rotor_inertia or ROTOR_INERTIA * (mass / ROTOR_MASS) ** (5 / 3)
    return Motor(
        name=row.part,
        gear_ratio=ratio,
        voltage=supply,
        stall_torque=constant * ratio * (stalled - share * free) if given or supply != rated else torque,
        no_load_speed=no_load / ratio,
        stall_current=stalled,
        no_load_current=(friction + viscous * no_load) / back_emf,
        mass=mass,
        inductance=options.inductance or row.inductance or ELECTRICAL_TIME * resistance,
        rotor_inertia=inertia,
        friction=friction,
        viscous=viscous,
        back_emf_constant=back_emf,
        torque_constant=constant,
        resistance=resistance,
        torque_limit=row.torque_limit,
        rated_voltage=rated,
    )


def estimates_of(row: GearMotorRow, options: MotorOptions) -> list[str]:
    """The estimated constants of this motor, in words."""
    found = []
    if not (options.rotor_inertia or row.rotor_inertia):
        found.append("rotor inertia estimated from a public estimate, by geometric similarity")
    if not (options.inductance or row.inductance):
        found.append("inductance estimated from an electrical time constant of 0.25 ms")
    if row.basis_remark.startswith(OTHER_CURRENTS):
        derived = "back-EMF constant and efficiency" if options.resistance or row.resistance else (
            "resistance, back-EMF constant and efficiency"
        )  # fmt: skip
        found.append(f"stall and no-load {row.basis_remark}; {derived} follow from them")
    if row.interpolated:
        found.append("speed and torque are not published, but interpolated between the maker's neighbouring ratios")
    return found


def chosen_rows(rows: Sequence[GearMotorRow], patterns: Sequence[str]) -> list[GearMotorRow]:
    """The complete rows whose part matches any pattern (``*``, ``N20 HP *``), in catalogue order.

    Raises
    ------
    UserError : a pattern matches no complete row; for a full part name the message says what it lacks.
    """
    found: list[GearMotorRow] = []
    for pattern in patterns:
        matched = [row for row in rows if fnmatch.fnmatchcase(row.part.casefold(), pattern.casefold())]
        if not matched:
            raise UserError(f'"{pattern}" matches no gear motor; see synth catalog list gearmotors')
        complete = [row for row in matched if row.complete]
        if not complete:
            raise UserError(f'"{pattern}" cannot be simulated: {_why_not(matched[0])}')
        found += [row for row in complete if row not in found]
    return found


def _why_not(row: GearMotorRow) -> str:
    """Why a row is not complete, in words that follow the pattern it matches."""
    if row.state == "contradiction":
        return f"the row of {row.part} contradicts itself: {'; '.join(row.reasons)}"
    return f"{row.part} is {row.status}"


def with_torque(motor: Motor, factor: float) -> Motor:
    """The motor with its torque constant and stall torque scaled."""
    return replace(motor, stall_torque=motor.stall_torque * factor, torque_constant=motor.torque_constant * factor)


def with_speed(motor: Motor, factor: float) -> Motor:
    """The motor with another no-load speed at the same stall torque and currents: its back-EMF constant scales."""
    return replace(
        motor,
        no_load_speed=motor.no_load_speed * factor,
        back_emf_constant=motor.back_emf_constant / factor,
        friction=motor.friction / factor,
        viscous=motor.viscous / factor**2,
    )


def with_loss(motor: Motor, factor: float) -> Motor:
    """The motor with its no-load current scaled, at the maker's free speed, stall torque and stall current.

    These give the constants of ``motor_of``: with a larger no-load current a smaller K_e and a larger K_t. A current at
    which the motor would not turn is reduced to one at which it hardly turns.
    """
    rated, supply, resistance = motor.rated_voltage or motor.voltage, motor.voltage, motor.resistance
    dry, rising = motor.friction / motor.back_emf_constant, motor.viscous / motor.back_emf_constant  # A, A s/rad
    speed = _free_speed(rated, resistance, motor.back_emf_constant, dry, rising)
    most = HARDLY_TURNING * min(rated, supply) / (resistance * (dry + rising * speed))
    scale = min(factor, max(1.0, most))
    new_dry, new_rising = scale * dry, scale * rising
    back_emf = (rated - (new_dry + new_rising * speed) * resistance) / speed
    constant = motor.torque_constant * (rated / resistance - dry) / (rated / resistance - new_dry)
    no_load = _free_speed(supply, resistance, back_emf, new_dry, new_rising)
    return replace(
        motor,
        stall_torque=constant * motor.gear_ratio * (supply / resistance - new_dry),
        no_load_speed=no_load / motor.gear_ratio,
        no_load_current=new_dry + new_rising * no_load,
        friction=back_emf * new_dry,
        viscous=back_emf * new_rising,
        back_emf_constant=back_emf,
        torque_constant=constant,
    )


def _free_speed(voltage: float, resistance: float, back_emf: float, dry: float, rising: float) -> float:
    """The rotor's free speed, rad/s: of V = R i + K_e w with i = dry + rising w."""
    return (voltage - dry * resistance) / (back_emf + rising * resistance)
