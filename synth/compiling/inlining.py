"""Small laws that numba inlines into the calling loop, where branch-free code is vectorised."""

from __future__ import annotations

from typing import Any

from numba import njit

inlined: Any = njit(inline="always", fastmath=True, error_model="numpy")
