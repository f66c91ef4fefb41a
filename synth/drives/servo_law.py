"""The torque of a position servo, compiled into the lane loop of its plant."""

from __future__ import annotations

from synth.compiling.inlining import inlined
from synth.drives.motor_law import steady_line


@inlined
def servo_duty(error, rate, gain, damping_gain, dead_band, duty_limit, integral):  # type: ignore[no-untyped-def]
    """Duty that a controller sets, branch-free.

    ``error`` rad, command minus angle; ``rate`` rad/s of the joint; ``gain`` duty/rad outside the ``dead_band`` rad,
    ``damping_gain`` duty s/rad, and the duty of the ``integral``; in sum at most ``duty_limit``.
    """
    beyond = error - max(-dead_band, min(dead_band, error))
    return max(-duty_limit, min(duty_limit, gain * beyond - damping_gain * rate + integral))


@inlined
def integral_change(error, integral, dead_band, integral_gain, integral_limit):  # type: ignore[no-untyped-def]
    """Duty/s by which the ``integral`` grows: ``integral_gain`` duty/(rad s) times the error outside the dead band.

    It stays within ``integral_limit``: clamping against windup (Astrom & Hagglund, *Advanced PID Control*, section
    3.5). Beyond its limit it can only return.
    """
    change = integral_gain * (error - max(-dead_band, min(dead_band, error)))
    return change if abs(integral) < integral_limit or integral * change < 0.0 else 0.0


@inlined
def unlimited_torque(duty, rate, supply, strength, back_emf, sag, warm):  # type: ignore[no-untyped-def]
    """Torque on the joint, N m, of a winding whose current nothing limits; ``supply`` V.

    The winding gives ``strength`` N m/V less ``back_emf``
    N m s/rad (direct-current motor at steady current, Hughes & Drury, *Electric Motors and Drives*, 4th ed.,
    section 3.4). ``sag`` is the source's resistance over the winding's: with the duty d the source carries d times the
    winding's current, so the winding sees d V less d^2 times the source's drop. ``warm`` is the winding's resistance
    over that of these numbers.
    """
    return steady_line(strength * duty * supply, back_emf, rate) / (warm + sag * duty * duty)


@inlined
def limited(torque, enabled, torque_limit):  # type: ignore[no-untyped-def]
    """Torque on the joint, N m: at most ``torque_limit`` N m, by the current limit; ``enabled`` 0 opens the winding."""
    return enabled * max(-torque_limit, min(torque_limit, torque))


@inlined
def servo_torque(  # type: ignore[no-untyped-def]
    error,
    rate,
    supply,
    enabled,
    gain,
    damping_gain,
    dead_band,
    duty_limit,
    open_duty,
    strength,
    back_emf,
    torque_limit,
    sag,
    warm=1.0,
    integral=0.0,
):
    """Torque on the joint, N m, of a continuous controller with the duty of its ``integral``.

    ``open_duty`` is added without control.
    """
    duty = servo_duty(error, rate, gain, damping_gain, dead_band, duty_limit, integral) + open_duty
    return limited(unlimited_torque(duty, rate, supply, strength, back_emf, sag, warm), enabled, torque_limit)
