"""A planted leg as data: its parameters, the conditions of a trial, additional bodies and torque laws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PARAMETERS = ("length", "mass", "com", "inertia", "spring", "damper", "free_angle")  # as in ``tolerance:``
# Of a leg with motors, ``values`` has these rows too: each joint's constants over the designed ones.
MOTOR_PARAMETERS = ("torque_constant", "resistance")
ROWS = (*PARAMETERS, *MOTOR_PARAMETERS)


class PlantedServo(NamedTuple):
    """A joint's position servo with its motor, at the joint in SI.

    Its duty is ``gain`` 1/rad times the error beyond ``dead_band`` rad less ``damping_gain`` s/rad times the speed, at
    most ``duty_limit``, and ``open_duty`` without control. It gives ``strength`` N m/V, brakes by ``back_emf``
    N m s/rad, and is limited to ``torque_limit`` N m; ``sag`` is the source's resistance over the winding's. The
    command of ``delay`` s ago acts. Under a torque of ``reference`` N m the winding's resistance grows by ``rise`` (a
    share) in the end, by two thirds of that in ``warming`` s; with a rise of zero it stays. With a ``control_period`` s
    it looks at the start, at ``first_look`` s and then after each period, and holds its duty in between: one of
    ``duty_steps`` from 0 to 1 if that is not zero. ``integral_gain`` 1/(rad s) times the error beyond the dead band is
    the rate of a duty of at most ``integral_limit``. ``linear`` 1: it interpolates between two commands. It controls
    its joint's angle on q times one more than ``seen_scale``, plus ``seen_offset`` rad.
    """

    joint: int
    gain: float
    damping_gain: float
    dead_band: float
    duty_limit: float
    open_duty: float
    strength: float
    back_emf: float
    torque_limit: float
    sag: float
    delay: float
    rise: float = 0.0
    reference: float = 0.0
    warming: float = 0.0
    integral_gain: float = 0.0
    integral_limit: float = 0.0
    command_rate: float = 0.0  # rad/s at which its own command approaches the given one; 0: at once
    control_period: float = 0.0
    first_look: float = 0.0
    duty_steps: float = 0.0
    linear: float = 0.0
    seen_scale: float = 0.0
    seen_offset: float = 0.0

    def of_true_angle(self) -> PlantedServo:
        """The servo that does the same by the true angle, for commands as ``followed`` makes them."""
        seen = 1.0 + self.seen_scale
        return self._replace(
            gain=self.gain * seen,
            damping_gain=self.damping_gain * seen,
            integral_gain=self.integral_gain * seen,
            dead_band=self.dead_band / seen,
        )

    def with_constants(self, constant: float, resistance: float) -> PlantedServo:
        """With the motor's constants times these factors."""
        return self._replace(
            strength=self.strength * constant / resistance,
            back_emf=self.back_emf * constant**2 / resistance,
            torque_limit=self.torque_limit * constant,
            sag=self.sag / resistance,
        )

    def with_error(self, name: str, value: float) -> PlantedServo:
        """With one cause: a factor of gain, torque constant or resistance; another torque limit; else an addition."""
        if name in MOTOR_PARAMETERS:
            return self.with_constants(*(value if name == each else 1.0 for each in MOTOR_PARAMETERS))
        if name == "torque_limit":
            return self._replace(torque_limit=min(self.torque_limit, value))
        if name == "command_rate":
            return self._replace(command_rate=min(self.command_rate or value, value))
        if name == "gain":
            return self._replace(gain=self.gain * value)
        values = [float(each) for each in self[1:]]
        values[self._fields.index(name) - 1] += value
        return PlantedServo(self.joint, *values)


class ServoInputs(NamedTuple):
    """Inputs of a trial's servos: ``time`` (k,) s from the release, ``command`` (k, n) rad on q, held from each to the
    next unless the servo interpolates; ``supply`` (k, n) V and ``enabled`` (k, n) 1 or 0, linear between.
    """

    time: Array
    command: Array
    supply: Array
    enabled: Array


@dataclass(frozen=True)
class PlantedLeg:
    """A leg in SI. ``values`` (7, n) has a row for each of ``PARAMETERS``; free angles are rotations, not readings.

    With ``servos``, or with motors whose current is known, it is (9, n), see ``ROWS``; the known torques at the joints
    ``by_current`` are their currents times the designed constant.
    """

    names: tuple[str, ...]
    zero: Array  # (n,) rad, the reading when the link is aligned with its parent
    sign: Array  # (n,)
    tilt: float
    values: Array
    gravity: float = 9.81
    curves: tuple[tuple[int, Array], ...] = ()  # joint, and (k, 2) speed and torque of its damper, starting at (0, 0)
    rotors: Array | None = None  # (n,) kg m^2, the designed inertia that turns with each joint
    servos: tuple[PlantedServo, ...] = ()
    by_current: tuple[int, ...] = ()
    laws: tuple[Law, ...] = ()  # effects that the designed leg has
    com_across: Array | None = None  # (n,) m, how far each centre of mass lies beside its link's line; as designed

    @property
    def n(self) -> int:
        return len(self.names)

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows of ``values``."""
        return ROWS[: len(self.values)]

    def with_values(self, values: Array) -> PlantedLeg:
        """The leg with these parameters."""
        return replace(self, values=values)

    def of(self, name: str) -> Array:
        """(n,) values of one parameter, one per joint."""
        return np.asarray(self.values[ROWS.index(name)])

    def torque_factor(self, joint: int) -> float:
        """A known torque as built over the designed one: the motor's constant, where its current was recorded."""
        return float(self.of("torque_constant")[joint]) if joint in self.by_current else 1.0

    def changed(self, name: str, joint: int, value: float) -> PlantedLeg:
        """The leg with one parameter of one joint replaced."""
        values = self.values.copy()
        values[ROWS.index(name), joint] = value
        return replace(self, values=values)

    def moved_across(self, joint: int, by: float) -> PlantedLeg:
        """The leg with one link's centre of mass farther beside its line by so many m."""
        across = np.zeros(self.n) if self.com_across is None else self.com_across.copy()
        across[joint] += by
        return replace(self, com_across=across)

    def reading(self, rotation: Array) -> Array:
        """Measured angles (..., n) rad at these rotations (..., n) rad."""
        return self.zero + self.sign * rotation

    def outboard(self, joint: int) -> float:
        """Moment of inertia of all outboard links about a joint, kg m^2: straight chain, with the joint's rotor."""
        total, reach = 0.0, 0.0
        for i in range(joint, self.n):
            length, mass, com, inertia = self.values[:4, i]
            beside = 0.0 if self.com_across is None else float(self.com_across[i])
            total += inertia + mass * ((reach + com) ** 2 + beside**2)
            reach += length
        return total + (0.0 if self.rotors is None else float(self.rotors[joint]))


class PlantedTrial(NamedTuple):
    """The conditions of one trial.

    ``pose`` : (n,) rad, rotations at the release. ``start`` : s from the release to the first sample. ``known`` : times
    (k,) s from the release and joint torques (k, n) N m, interpolated linearly. ``speed`` : (n,) rad/s at the release;
    None: from rest.
    """

    pose: Array
    duration: float
    start: float = 0.0
    tip_mass: float = 0.0
    locked: tuple[int, ...] = ()
    tilt: float = 0.0
    held_out: bool = False
    outside: bool = False
    # Driven joint, then amplitude (N m), angular frequency (1/s) and phase of each of two sines; the torque acts on q.
    drive: tuple[float, ...] = ()
    known: tuple[Array, Array] | None = None
    speed: Array | None = None
    tip_inertia: float = 0.0
    tip_at: float | None = None
    inputs: ServoInputs | None = None

    def strongest(self, joint: int) -> float:
        """Largest known torque at a joint, N m; 0 if the joint is locked."""
        if joint in self.locked:
            return 0.0
        if self.known is not None:
            return float(np.abs(self.known[1][:, joint]).max())
        return self.drive[1] + self.drive[4] if self.drive and int(self.drive[0]) == joint else 0.0

    def torque(self, times: Array) -> Array:
        """Torque (m,) N m of the two sines of ``drive`` at ``times`` (m,) s from the release."""
        a, w, p, b, v, r = self.drive[1:]
        return np.asarray(a * np.sin(w * times + p) + b * np.sin(v * times + r))


class Law(NamedTuple):
    """A law of ``torque_laws`` at a joint (index among the leg's joints), optionally coupled to a second joint."""

    law: int
    joint: int
    par: tuple[float, ...]
    second: int = -1
    base: bool = False  # acts on the base's first coordinate instead of a joint


class Base(NamedTuple):
    """A moving mount: its bodies from the ground up, each (hinge or slide, direction, arm, mass, inertia, k, b)."""

    bodies: tuple[tuple[float, ...], ...]


class Bend(NamedTuple):
    """A bending link: hinges at these shares of its length, each with a rate and a damping."""

    joint: int
    shares: tuple[float, ...]
    rates: tuple[float, ...]
    dampings: tuple[float, ...]


@dataclass(frozen=True)
class Truth:
    """The true leg of a case: parameters, additional bodies and laws, and errors of the mount and the known torque."""

    leg: PlantedLeg
    laws: tuple[Law, ...] = ()
    base: Base | None = None
    bends: tuple[Bend, ...] = ()
    tilt: float = 0.0  # rad, of the mount, added to the leg's and the trial's
    bare: tuple[int, ...] = ()  # joints whose spring and damper are replaced by a law (backlash)
    rotors: tuple[tuple[int, float], ...] = ()  # joint, additional inertia that turns with it, kg m^2
    drive: tuple[float, float, float] = (0.0, 0.0, 0.0)  # errors of a known torque: gain (share), offset N m, delay s
    drive_joint: int = -1  # the joint whose known torque has the errors, if several are driven
    servo_errors: tuple[tuple[int, str, float], ...] = ()  # joint, name and value, see ``PlantedServo.with_error``

    def servos(self) -> list[PlantedServo]:
        """The servos as built, with their causes."""
        made = []
        for servo in self.leg.servos:
            found = servo.with_constants(*(float(self.leg.of(name)[servo.joint]) for name in MOTOR_PARAMETERS))
            for joint, name, value in self.servo_errors:
                found = found.with_error(name, value) if joint == servo.joint else found
            made.append(found)
        return made
