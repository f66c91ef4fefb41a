"""The result of one check, and the error that stops an export."""

from __future__ import annotations

from dataclasses import dataclass

ROUNDING = 1e-9  # mm, rounding of sums of dimensions


@dataclass(frozen=True)
class CheckResult:
    """One check: measured value, limit, and whether it passed.

    ``angle``: the measured joint angle (deg) of the worst value, if it depends on the angle; used for the picture.
    """

    name: str
    part: str
    passed: bool
    value: float
    limit: float
    unit: str
    text: str
    angle: float | None = None

    def __str__(self) -> str:
        verdict = "passed" if self.passed else "FAILED"
        return (
            f"{verdict}: {self.part}: {self.name}: {self.value:.6g} (limit {self.limit:.6g}) {self.unit}; {self.text}"
        )


class GateError(RuntimeError):
    """One or more checks failed; ``results`` has all of them, passed and failed."""

    def __init__(self, results: tuple[CheckResult, ...]) -> None:
        self.results = results
        super().__init__("\n".join(str(result) for result in results if not result.passed))


def _without_residue(value: float) -> float:
    """The value without a negative zero or rounding residue, which differ between runs."""
    return 0.0 if abs(value) < ROUNDING else float(value)


def check_at_most(
    name: str, part: str, value: float, limit: float, unit: str, text: str, *, angle: float | None = None
) -> CheckResult:
    """A check that passes if ``value`` does not exceed ``limit``."""
    return CheckResult(name, part, bool(value <= limit), _without_residue(value), float(limit), unit, text, angle)


def check_at_least(
    name: str, part: str, value: float, limit: float, unit: str, text: str, *, angle: float | None = None
) -> CheckResult:
    """A check that passes if ``value`` is at least ``limit``."""
    return CheckResult(name, part, bool(value >= limit), _without_residue(value), float(limit), unit, text, angle)


def require(results: tuple[CheckResult, ...]) -> None:
    """Raise :class:`GateError` if any check failed."""
    if not all(result.passed for result in results):
        raise GateError(results)
