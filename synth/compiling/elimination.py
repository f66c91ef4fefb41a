"""Source text that solves a small symmetric system J x = r, unrolled.

L D L^T: Golub & Van Loan, *Matrix Computations*, 4th ed., algorithm 4.1.2. Up to three unknowns Cramer's rule is
faster, because it divides once: a division takes as long as sixteen multiplications. The lines read J{i}{j} for i <= j
and use the names l{i}{j}, z{i}{j}, y{i}, inverse{j}, A{i}{j} and inverse.
"""

from __future__ import annotations

from collections.abc import Sequence

MOST_BY_MINORS = 3  # unknowns; with four the minors cost more than the divisions


def solve(n: int, *systems: tuple[str, Sequence[str]]) -> list[str]:
    """Lines that set ``name0 ...`` of each system, a name and n right-hand terms, to its solution."""
    if n > MOST_BY_MINORS:
        return factorise(n) + [line for name, right in systems for line in substitute(n, name, right)]
    lines = _minors(n)
    for name, right in systems:
        for i in range(n):
            terms = [f"A{min(i, j)}{max(i, j)} * ({right[j]})" for j in range(n) if right[j] != "0.0"]
            lines.append(f"{name}{i} = inverse * ({' + '.join(terms)})")
    return lines


def _minors(n: int) -> list[str]:
    """Lines that set A{i}{j} to the signed minors of J, and ``inverse`` to one over its determinant."""
    if n == 1:
        return ["A00 = 1.0", "inverse = 1.0 / J00"]
    if n == 2:
        return ["A00 = J11", "A01 = -J01", "A11 = J00", "inverse = 1.0 / (J00 * J11 - J01 * J01)"]
    return [
        "A00 = J11 * J22 - J12 * J12",
        "A01 = J02 * J12 - J01 * J22",
        "A02 = J01 * J12 - J02 * J11",
        "A11 = J00 * J22 - J02 * J02",
        "A12 = J01 * J02 - J00 * J12",
        "A22 = J00 * J11 - J01 * J01",
        "inverse = 1.0 / (J00 * A00 + J01 * A01 + J02 * A02)",
    ]


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
