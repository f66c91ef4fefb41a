"""Whether a clock of the recordings that runs too fast or too slow explains them as well as the causes that were found.

No effect of the library changes the clock, and several that are absent stand for it together: in a log's time a clock
3 % slow is a leg of 6 % more inertia whose dampers, delays and control steps are 3 % off. It is one number where these
are several, so it is asked where more than one cause was found, or where they leave more than the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.cause_findings import Findings
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.restarts import refine
from synth.diagnosis.verdict import Judgement
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo
from synth.remarks import decisive
from synth.swing.leg_model import Leg
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

# A microcontroller's own oscillator is 1 to 3 % off and a loop that counts its steps instead of reading a clock, twice
# that; a worse clock shows in the length of a recording.
MOST_OFF = 0.08
LEAST_OFF = 0.003  # a smaller error of the clock is within the tolerances of the leg's inertias
EXACT = 1e-4  # of the clock's factor, to which it is searched: two digits are told
LEAST_MISFIT = 1.5  # noise floors: a single cause that leaves less is not doubted, and a clock that does is sure
# A clock that is off by more than ``TRIED`` is nearer there, by an eighth at ``MOST_OFF``; where neither side helps the
# clock is not searched for.
TRIED, HELPS = 0.01, 0.95
GRID = 17  # factors of the clock, ``TRIED`` apart
AS_GOOD = 1.05  # times the misfit of the causes, which the clock may leave: noise decides no nearer


def with_clock(trial: Trial, factor: float, early: float = 0.0) -> Trial:
    """The trial if its true time is ``factor`` times the recorded one, its commands ``early`` s before their stamps."""
    signals = trial.signals
    return replace(
        trial,
        time=trial.time * factor,
        velocities=None if trial.velocities is None else trial.velocities / factor,
        signals=None if signals is None else replace(signals, time=signals.time * factor - early),
    )


def doubting_clock(
    leg: Leg,
    findings: Findings[EvaluatedHypothesis, Array],
    trials: Sequence[Trial],
    bench_of: Callable[[list[Trial]], Workbench],
) -> Findings[EvaluatedHypothesis, Array]:
    """The findings with ``clock_warnings``."""
    told = clock_warnings(leg, findings.found, findings.judged, trials, bench_of)
    return replace(findings, warnings=(*findings.warnings, *told))


def clock_warnings(
    leg: Leg,
    found: Hypotheses[EvaluatedHypothesis],
    judged: Judgement[EvaluatedHypothesis],
    trials: Sequence[Trial],
    bench_of: Callable[[list[Trial]], Workbench],
) -> tuple[str, ...]:
    """A warning if a wrong clock leaves no more of the recordings than the causes do.

    ``bench_of`` : the workbench of the designed ``leg`` with changed ``trials``. A command that is in step with a
    servo's control falls out of it with another clock, by up to a control step: it is tried half a step earlier too.
    """
    left = judged.accepted.ratio
    if judged.verdict == "unknown":
        left = min(item.ratio for item in (found.none, *found.singles, *found.several))
    elif not judged.accepted.keys or (len(judged.accepted.keys) == 1 and left < LEAST_MISFIT):
        return ()

    early = max((step for trial in trials for step in _control_steps(trial.leg or leg)), default=0.0) / 2.0

    def misfit(factor: float) -> float:
        return min(
            _misfit(bench_of([with_clock(trial, factor, before) for trial in trials])) for before in {0.0, early}
        )

    if min(misfit(1.0 - TRIED), misfit(1.0 + TRIED)) > HELPS * found.none.ratio:
        return ()
    made = {float(factor): misfit(float(factor)) for factor in np.linspace(1.0 - MOST_OFF, 1.0 + MOST_OFF, GRID)}
    best = min(made, key=lambda factor: made[factor])
    limits = max(best - TRIED, min(made)), min(best + TRIED, max(made))
    from scipy.optimize import minimize_scalar  # imported here: it takes 0.2 s, and few clocks are doubted

    near = minimize_scalar(misfit, bounds=limits, method="bounded", options={"xatol": EXACT})
    return _warning(float(near.x), float(near.fun), left)


def _control_steps(leg: Leg) -> list[float]:
    """S, the control periods of the leg's servos."""
    return [joint.drive.control_period for joint in leg.joints if isinstance(joint.drive, Servo)]


def _misfit(bench: Workbench) -> float:
    """Noise floors that the designed leg leaves within its tolerances."""
    (fit,) = refine(bench, bench.evaluate([as_designed(bench)]))
    return rms_over_noise(bench, fit)


def _warning(factor: float, after: float, left: float) -> tuple[str, ...]:
    """``after``, ``left`` : times the noise that the clock and the causes leave.

    How far the clock is off is told only where it leaves the noise: commands that fall out of step with the control of
    a servo leave more, nearly alike over several per cent.
    """
    if abs(factor - 1.0) < LEAST_OFF or after > AS_GOOD * left:
        return ()
    off = f"{significant(100.0 * abs(factor - 1.0), 2)} %" if after < LEAST_MISFIT else "some per cent"
    text = (
        f"a clock of the recordings that is {off} {'slow' if factor > 1.0 else 'fast'} explains them as well without "
    )
    text += (
        f"any cause: it leaves {significant(after, 2)} times the noise, the best causes {significant(left, 2)} times. "
    )
    return (decisive(text + "Compare the length of a recording with a stopwatch before you believe a cause"),)
