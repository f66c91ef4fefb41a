"""Calibration of spring-back and rate by wound samples: factors on the formulas' results for a wire and a winder.

A sample is a coil that was wound on a mandrel, released and measured. Its mean diameter D is measured, or follows from
the turns wound n and the coils left N, because the wire's length is constant: ``D = (D_mandrel + d) n / N``. The
bending model of ``winding`` then gives the flow stress of the wire. The measured rate gives the error of the rate
formula for this wire and coil.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from synth.errors import Problem, UserError
from synth.parts.coil_rate import RATE_FORMULA, RateForm, active_coils, rate
from synth.spring.winding import mandrel_diameter

FLOW_RANGE = (0.2, 2.0)  # of the tensile strength: a flow stress outside it means that a measurement is wrong
# Of a measured rate over the formula's. Friction and an uneven coil take a tenth. The rate goes with the fourth power
# of the wire's diameter, so a factor of two is a diameter 19 % off. A rate per degree read as per radian is 57 times.
RATE_RANGE = (0.5, 2.0)


@dataclass(frozen=True)
class Sample:
    """One wound coil: sizes in m, ``turns`` wound on the mandrel, ``coils`` left when free, ``rate`` in N m/rad.

    ``mean`` is the free coil's mean diameter; None if only turns and coils were counted. ``legs``: lengths from the
    coil to the load, m. ``line`` : of its table, in messages.
    """

    mandrel: float
    wire: float
    coils: float
    turns: float | None = None
    mean: float | None = None
    rate: float | None = None
    legs: tuple[float, float] = (0.0, 0.0)
    line: int | None = None

    @property
    def free_mean(self) -> float | None:
        """Mean diameter of the free coil, m: as measured, else from the numbers of turns and coils."""
        if self.mean is not None:
            return self.mean
        return None if self.turns is None else (self.mandrel + self.wire) * self.turns / self.coils


@dataclass(frozen=True)
class WindingCalibration:
    """Factors on the wire's flow stress (nominally its tensile strength) and on the rate.

    ``spread`` is one standard deviation of the rate factor. ``n_back`` and ``n_rate``: numbers of samples used.
    ``material`` : the samples' wire; empty: any. ``form`` : the formula that ``rate`` is a factor on; None: either.
    """

    spring_back: float = 1.0
    rate: float = 1.0
    spread: float | None = None
    n_back: int = 0
    n_rate: int = 0
    material: str = ""
    form: RateForm | None = None

    def require_for(self, material: str, form: RateForm) -> None:
        """Refuse another wire than that of the samples, and another rate formula than the factor's.

        Raises
        ------
        UserError : with each.
        """
        wrong = []
        if self.material not in ("", material):
            wrong.append(f"was measured on {self.material}, and the spring is of {material}: wind samples of that wire")
        if self.n_rate and self.form not in (None, form):
            made, used = (RATE_FORMULA[each] for each in (self.form, form) if each is not None)
            text = f"is a factor on the rate formula {made}, and {used} is chosen: use {made} here"
            wrong.append(f"{text} (--rate-formula {made}), or calibrate with {used}")
        if wrong:
            raise UserError([Problem(f"the calibration {text}") for text in wrong])


UNCALIBRATED = WindingCalibration()


def flow_factor(sample: Sample, modulus: float, strength: float) -> float | None:
    """Flow stress over ``strength`` for which the sample's mandrel gives its free coil; None if none of ``FLOW_RANGE``.

    ``modulus`` and ``strength`` in Pa. By bisection: a higher flow stress means more spring-back, so the same coil
    needs a thinner mandrel.
    """
    mean = sample.free_mean
    if mean is None or mean <= sample.mandrel + sample.wire:
        return None
    low, high = FLOW_RANGE
    if not (
        mandrel_diameter(mean, sample.wire, modulus, high * strength)
        <= sample.mandrel
        <= mandrel_diameter(mean, sample.wire, modulus, low * strength)
    ):
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        thicker = mandrel_diameter(mean, sample.wire, modulus, middle * strength) > sample.mandrel
        low, high = (middle, high) if thicker else (low, middle)
    return 0.5 * (low + high)


def rate_factor(sample: Sample, modulus: float, form: RateForm = "bending") -> float | None:
    """Measured rate over the formula's for ``modulus`` Pa; None if rate or diameter were not measured."""
    mean = sample.free_mean
    if sample.rate is None or mean is None:
        return None
    active = active_coils(sample.coils, mean, sample.legs)
    return sample.rate / rate(modulus, sample.wire, mean, active, form)


def mean_calibration(flows: Sequence[float], rates: Sequence[float]) -> WindingCalibration:
    """Geometric means of the samples' factors; 1 if no sample determines one."""
    logs = [math.log(value) for value in rates]
    middle = sum(logs) / len(logs) if logs else 0.0
    spread = math.sqrt(sum((x - middle) ** 2 for x in logs) / (len(logs) - 1)) if len(logs) > 1 else None
    back = math.exp(sum(math.log(value) for value in flows) / len(flows)) if flows else 1.0
    return WindingCalibration(back, math.exp(middle), spread, len(flows), len(rates))
