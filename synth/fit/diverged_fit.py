"""A fit whose sensitivities are not finite is refused in the words of the leg file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from synth.errors import UserError
from synth.estimation.intervals import NotFiniteError

UNKNOWN_UNCERTAINTY = (
    "the simulated motion diverges at the fit's last point, so its uncertainty is unknown. Check the leg file's "
    "units and signs, and leave recordings out one by one: `synth fit` names those that do not fit"
)


@contextmanager
def divergence_refused() -> Iterator[None]:
    """Within it, matrices that are not finite are a mistake in the user's input.

    Raises
    ------
    UserError : one is not finite.
    """
    try:
        yield
    except NotFiniteError as error:
        raise UserError(UNKNOWN_UNCERTAINTY) from error
