"""Small laws that numba copies into the loop that calls them, where branch-free code becomes vector code."""

from __future__ import annotations

from typing import Any

from numba import njit

inlined: Any = njit(inline="always", fastmath=True, error_model="numpy")
