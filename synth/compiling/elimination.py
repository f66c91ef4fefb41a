"""Source text that solves a small symmetric system J x = r by an unrolled L D L^T factorisation.

Golub & Van Loan, *Matrix Computations*, 4th ed., algorithm 4.1.2. The lines read J{i}{j} for i <= j
and use the names l{i}{j}, z{i}{j}, y{i} and inverse{j}.
"""

from __future__ import annotations

from collections.abc import Sequence


def factorise(n: int) -> list[str]:
    """Lines that factorise the n x n matrix J."""
    lines = []
    for j in range(n):
        for i in range(j, n):
            value = f"J{j}{i}" + "".join(f" - z{i}{m} * l{j}{m}" for m in range(j))
            if i == j:
                lines.append(f"inverse{j} = 1.0 / ({value})")
            else:
                lines += [f"z{i}{j} = {value}", f"l{i}{j} = z{i}{j} * inverse{j}"]
    return lines


def substitute(n: int, name: str, right: Sequence[str]) -> list[str]:
    """Lines that set ``name0 ...`` to the solution for these n right-hand terms, after ``factorise``."""
    lines = [f"y{i} = {right[i]}" + "".join(f" - l{i}{m} * y{m}" for m in range(i)) for i in range(n)]
    for i in range(n - 1, -1, -1):
        lines.append(f"{name}{i} = y{i} * inverse{i}" + "".join(f" - l{m}{i} * {name}{m}" for m in range(i + 1, n)))
    return lines
