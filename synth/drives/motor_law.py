"""The equations of a motor and its gear, compiled into the loops of both plants: all at the joint, branch-free.

V = i R + L di/dt + K_e w (Hughes & Drury, *Electric Motors and Drives*, 4th ed., section 3.4; Knaup & Aukes, equations
3, 4 and 6). A winding without inductance is at its steady current, where torque falls with speed along a line.
"""

from __future__ import annotations

from math import sqrt

from synth.compiling.inlining import inlined


@inlined
def steady_line(standing, slope, rate):  # type: ignore[no-untyped-def]
    """A winding's torque, N m, or current, A, at steady current: ``standing`` at rest, falling by ``slope`` a rad/s."""
    return standing - slope * rate


@inlined
def current_change(voltage, current, rate, resistance, back_emf, inverse_inductance):  # type: ignore[no-untyped-def]
    """A/s in a winding with inductance; ``back_emf`` V s/rad of the joint, ``inverse_inductance`` 1/H."""
    return inverse_inductance * (voltage - resistance * current - back_emf * rate)


@inlined
def direction(rate, reverse_speed):  # type: ignore[no-untyped-def]
    """Sign of the ``rate``, smoothed over ``reverse_speed`` rad/s."""
    return rate / sqrt(rate * rate + reverse_speed * reverse_speed)


@inlined
def direction_slope(along, rate, reverse_speed):  # type: ignore[no-untyped-def]
    """Derivative by the rate, s/rad, of the ``direction`` whose value is ``along``."""
    return (1.0 - along * along) / sqrt(rate * rate + reverse_speed * reverse_speed)


@inlined
def after_friction(torque, along, rate, friction, viscous):  # type: ignore[no-untyped-def]
    """Torque less the motor's friction, N m: ``friction`` N m against ``along``, ``viscous`` N m s/rad."""
    return torque - friction * along - viscous * rate


@inlined
def transmitted_share(push, along, driving, braking):  # type: ignore[no-untyped-def]
    """Torque behind the gear over that before: ``driving`` where ``push`` is ``along`` the motion, or ``braking``."""
    with_it = along if push >= 0.0 else -along
    return 0.5 * (driving + braking) + 0.5 * with_it * (driving - braking)


@inlined
def transmitted_slope(push, driving, braking):  # type: ignore[no-untyped-def]
    """Derivative of ``transmitted_share`` by ``along``."""
    return 0.5 * (driving - braking) if push >= 0.0 else 0.5 * (braking - driving)
