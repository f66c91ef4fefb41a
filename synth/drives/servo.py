"""A joint's servo as data, and its inputs during a trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.drives.motor import GearedMotor


@dataclass(frozen=True)
class Servo:
    """A controller that holds a joint at a commanded angle.

    With a ``motor`` it sets the duty cycle of a half bridge: ``gain`` 1/rad and ``damping_gain`` s/rad give the
    duty, at most ``duty_limit``, of ``supply`` V whose source has ``source_resistance`` ohm; ``current_limit`` A in
    the winding. Without one the torque is immediate: ``gain`` N m/rad, ``damping_gain`` N m s/rad, at most
    ``torque_limit`` N m. ``dead_band`` rad to either side, in which the error counts as zero; ``delay`` s of a
    command. With a ``control_period`` s it samples command and angle only at each multiple of that time and holds
    the duty, or the torque, in between; 0: continuous control. ``duty_steps`` : number of steps of its duty from 0
    to 1; 0: none. ``linear_commands`` : it interpolates between two commands, instead of holding each to the next.
    ``command_rate_limit`` rad/s, by which its own command approaches the given one (a profile velocity); 0: at once.
    ``integral_gain`` 1/(rad s), or N m/(rad s), of the integral of the same error, which stays within
    ``integral_limit``, a duty or N m; by default that of the whole controller.

    In a winding with inductance the torque is delayed by ``lag`` s. To first order this delays the command by the
    same time, reduces the damping gain by gain times lag, and reduces the apparent inertia of the rotor by lag times
    the winding's own damping. A damping gain reduces it by lag times its own too, but only while the duty is below its
    limit; that part is left out. It would make small steps ten times more accurate (0.003 instead of 0.03 deg) and
    hard ones up to ten times less (0.8 instead of 0.08 deg; ``tests/drives/test_inductance.py``'s arm). What it does
    to an integral is left out too.
    """

    gain: float
    damping_gain: float = 0.0
    delay: float = 0.0
    dead_band: float = 0.0
    duty_limit: float = 1.0
    torque_limit: float = np.inf
    current_limit: float = np.inf
    supply: float = 1.0
    source_resistance: float = 0.0
    motor: GearedMotor | None = None
    open_duty: float = 0.0  # 1 if the motor's voltage is known and nothing is controlled
    control_period: float = 0.0
    duty_steps: float = 0.0
    linear_commands: bool = False
    command_rate_limit: float = 0.0
    integral_gain: float = 0.0
    integral_limit: float = np.inf

    @property
    def numbers(self) -> tuple[float, ...]:
        """The servo in the order of ``servo_torque``'s arguments from ``gain`` on, then what is not of the law.

        These are its delay, of control steps their period, the first of them, and the steps of the duty; 1/ohm of its
        winding, the limit of its command's rate, and gain and limit of its integral. All numbers are finite, and
        include the winding's lag.
        """
        return tuple(delayed(np.array(self.without_lag), self.lag).tolist())

    @property
    def lag(self) -> float:
        """Electrical time constant of the winding, s; 0 without a motor."""
        return 0.0 if self.motor is None else self.motor.lag

    @property
    def without_lag(self) -> tuple[float, ...]:
        """The ``numbers`` of the same servo whose winding has no inductance."""
        motor = self.motor
        if motor is None:
            limit = min(self.torque_limit, UNLIMITED)
            # An unlimited duty at one volt and one newton metre per volt.
            controller = self.gain, self.damping_gain, self.dead_band, UNLIMITED, 0.0
            timing = self.delay, self.control_period, 0.0, 0.0
            integral = self.integral_gain, min(self.integral_limit, limit)
            return *controller, 1.0, 0.0, limit, 0.0, *timing, 0.0, self.command_rate_limit, *integral
        limit = min(self.torque_limit, self.current_limit * motor.torque_a_current, UNLIMITED)
        sag = self.source_resistance / motor.resistance
        strength, back_emf = motor.strength, motor.short_circuit_damping
        controller = self.gain, self.damping_gain, self.dead_band, self.duty_limit, self.open_duty
        control = self.control_period, 0.0, self.duty_steps
        integral = self.integral_gain, min(self.integral_limit, self.duty_limit)
        more = 1.0 / motor.resistance, self.command_rate_limit, *integral
        return *controller, strength, back_emf, limit, sag, self.delay, *control, *more

    def torque(
        self,
        error: Array,
        rate: Array,
        supply: Array | float,
        enabled: Array | float = 1.0,
        integral: Array | float = 0.0,
    ) -> Array:
        """(m,) N m along a motion: the result of ``servo_torque``, without the delay and without control steps.

        ``integral`` : the result of ``integral_along``.
        """
        from synth.drives.servo_law import servo_torque  # with numba, which takes longer to import than a leg to read

        along = np.vectorize(servo_torque.py_func, otypes=[float])
        return np.asarray(along(error, rate, supply, enabled, *self.numbers[:OF_THE_LAW], 1.0, integral))


@dataclass(frozen=True)
class TorqueDrive:
    """A drive whose torque is known: of a ``motor`` whose current is recorded, or, without one, as such."""

    motor: GearedMotor | None = None


def fed_together(drives: Sequence[Servo | TorqueDrive | None]) -> list[int]:
    """Indices of the servos that one source feeds: those of several motors whose stated supply is the same.

    Of several such groups the largest; of equally large ones the first.
    """
    groups: dict[float, list[int]] = {}
    for index, drive in enumerate(drives):
        if isinstance(drive, Servo) and drive.motor is not None and not drive.open_duty:
            groups.setdefault(drive.supply, []).append(index)
    largest = max(groups.values(), key=len, default=[])
    return largest if len(largest) > 1 else []


# Among a servo's numbers:
GAIN, DAMPING_GAIN, DEAD_BAND, DELAY, FIRST_STEP, INTEGRAL_GAIN, INTEGRAL_LIMIT = 0, 1, 2, 9, 11, 15, 16


def delayed(numbers: Array, lag: Array | float) -> Array:
    """The ``numbers`` (17, ...) of servos without inductance if their windings' time constant is ``lag`` (...) s.

    To first order, see ``Servo``; ``lightened`` is its part for the inertia.
    """
    found = numbers.copy()
    found[DAMPING_GAIN] -= lag * found[GAIN]
    found[DELAY] += lag
    found[FIRST_STEP] += lag
    return found


def holding_duty(load: Array, standing: Array, sag: Array) -> Array:
    """(...) duty d at which a motor at rest gives the ``load`` N m.

    The smaller root of load (1 + sag d^2) = d standing. ``standing`` N m at full duty from a source without
    resistance; ``sag`` as in ``servo_law.unlimited_torque``. Where the motor cannot give so much, a duty beyond that
    at which it gives most.
    """
    left = np.sqrt(np.maximum(standing**2 - 4.0 * sag * load**2, 0.0))
    whole = standing + left
    return np.divide(2.0 * load, whole, out=np.zeros_like(load), where=whole > 0.0)


def integral_along(time: Array, error: Array, enabled: Array, numbers: Array, start: float) -> Array:
    """(m,) duty of a servo's integral along a motion, by Euler's method from sample to sample; ``start`` : the first.

    ``time`` (m,) s, ``error`` (m,) rad, ``enabled`` (m,) 1 or 0; ``numbers`` (17,) of the servo. Zeros without a gain.
    """
    from synth.drives.servo_law import integral_change  # with numba, see ``Servo.torque``

    gain, limit = numbers[INTEGRAL_GAIN], numbers[INTEGRAL_LIMIT]
    found = np.zeros(len(time))
    if gain == 0.0:
        return found
    found[0] = start
    steps = np.diff(time) * enabled[:-1]
    for i, (step, wrong) in enumerate(zip(steps.tolist(), error[:-1].tolist(), strict=True)):
        change = integral_change.py_func(wrong, found[i], numbers[DEAD_BAND], gain, limit)
        found[i + 1] = min(max(found[i] + step * change, -limit), limit)
    return found


def lightened(inertia: Array | float, damping: Array | float, lag: Array | float) -> Array:
    """Kg m^2, the ``inertia`` that turns with a joint less what the delayed braking of a winding takes.

    Torque -b w(t - lag) is -b w + b lag dw/dt to first order; ``damping`` b, N m s/rad, of the short-circuited winding.
    """
    return np.asarray(inertia - lag * damping)


OF_THE_LAW = 9  # arguments of ``servo_torque`` among a servo's numbers
UNLIMITED = 1e12  # N m or duty: above any real limit, and still finite


@dataclass(frozen=True)
class ServoSignals:
    """The inputs of a trial's servos, in the sense of q.

    ``time`` (m,) s; ``command`` (m, n) rad; ``supply`` (m, n) V; ``enabled`` (m, n) 1 or 0. All are linear between, but
    the commands of the joints ``held`` are held from each time to the next.
    """

    time: Array
    command: Array
    supply: Array
    enabled: Array
    held: tuple[int, ...] = ()

    def widened(self, n: int, own: Sequence[int]) -> ServoSignals:
        """The same for a chain of ``n`` links, of which ``own`` belong to the leg."""

        def wide(values: Array) -> Array:
            made = np.zeros((len(values), n))
            made[:, list(own)] = values
            return made

        held = tuple(own[j] for j in self.held)
        return ServoSignals(self.time, wide(self.command), wide(self.supply), wide(self.enabled), held)

    def later(self, start: float) -> ServoSignals:
        """The same with time counted from ``start`` s."""
        return replace(self, time=self.time - start)

    def commands_held(self, time: Array) -> Array:
        """(k, n) rad, the commands at ``time`` (k,) s: the last sample of a held one, between two of another."""
        last = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, None)
        columns = [
            self.command[last, j] if j in self.held else np.interp(time, self.time, self.command[:, j])
            for j in range(self.command.shape[1])
        ]
        return np.stack(columns, axis=1)

    def at(self, time: Array, delay: Array) -> tuple[Array, Array, Array]:
        """Command delayed by each joint's ``delay`` (n,) s, supply and switch, each (k, n) at ``time`` (k,) s.

        A held command is its mean from half an interval of ``time`` before to half after: samples of it preserve
        impulses. At a single time it is what is held then.
        """
        columns = range(self.command.shape[1])
        command = [
            self._mean(j, time - delay[j]) if j in self.held
            else np.interp(time - delay[j], self.time, self.command[:, j])
            for j in columns
        ]  # fmt: skip
        supply, enabled = (
            [np.interp(time, self.time, values[:, j]) for j in columns] for values in (self.supply, self.enabled)
        )
        return np.stack(command, axis=1), np.stack(supply, axis=1), np.stack(enabled, axis=1)

    def _mean(self, j: int, time: Array) -> Array:
        """(k,) rad: a held command around each ``time`` (k,) s; its integral is linear between its samples."""
        told = self.command[:, j]
        wide = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        if wide == 0.0:
            return np.asarray(told[np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, None)])
        first, last = time[0] - wide, time[-1] + wide
        knots = np.r_[min(first, self.time[0] - wide), self.time, max(last, self.time[-1] + wide)]
        integral = np.r_[0.0, np.cumsum(np.diff(knots) * np.r_[told[0], told])]
        ends = [np.interp(time + side, knots, integral) for side in (0.5 * wide, -0.5 * wide)]
        return np.asarray((ends[0] - ends[1]) / wide)
