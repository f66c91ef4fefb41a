"""Source text of the functions of the implicit step, unrolled for a number of links; see ``curve_integrator``.

``Z`` is the workspace of ``lane_layout``, ``S`` the working array of ``stage_rows``; both are flat, 16 lanes a row.
"""

from __future__ import annotations

from synth.compiling.elimination import solve
from synth.swing.chain_source import DECORATOR, HEADER, equations_of_motion, lane_loop, link_directions
from synth.swing.lane_layout import CURVE_POINTS, LANES, PLACE, Layout
from synth.swing.stage_rows import (
    AT_SHARES,
    AVERAGED,
    DAMPED,
    ERROR,
    EVALUATED,
    FILTER,
    INTEGRAL,
    INVERSE,
    MASSES,
    MOST_STAGED,
    RATE_SCALE,
    SHARE_WEIGHTS,
    STAGES,
    WEIGHTS,
    mass_entry,
    pair,
    place,
    single_place,
)

# Called by the functions below, in the same module.
_OF_BOTH = "void(float64[::1], float32[::1])"
_INNER = "@njit(fastmath=True, error_model='numpy', nogil=True)"


def stage_functions(layout: Layout) -> str:
    """Source of ``begin(Z, S)``, ``iterate(Z, S, L, fresh)`` and ``filter_error(S, L)``.

    ``L`` : the array of single precision. ``begin`` takes the state at the start of a step from ``S`` and evaluates
    equations and damper there. ``iterate`` is one Newton iteration for the rates of all stages; ``fresh`` : not 0 makes
    the matrix in ``L`` anew. ``filter_error`` estimates the step's error.
    """
    n = layout.n
    texts = [
        lane_loop("equations", _equations(layout), "Z, S, base", _INNER, link_directions(layout)),
        _joint_loop("average_torques", n, _average_torques()),
        _to_single(n),
        _joint_loop("average_slopes", n, _average_slopes(), "L"),
        lane_loop("factorise_stages", _factorise(n), "L", _INNER),
        lane_loop("find_residuals", _residuals(n), "S, L", _INNER),
        lane_loop("solve_stages", _solve(n), "L", _INNER),
        lane_loop("change_stages", _change(n), "S, L", _INNER),
        _joint_loop("start_torques", n, _at_start()),
        _begin(layout),
        _iterate(layout),
        lane_loop("filter_error", _filter(n), "S, L", DECORATOR.format(signature=_OF_BOTH)),
    ]
    return HEADER + "from numba import njit\nfrom numpy import float32 as single\n" + "".join(texts)


def _begin(layout: Layout) -> str:
    decorator = DECORATOR.format(signature="void(float64[::1], float64[::1])")
    lines = [
        f"for e in range({layout.n * LANES}):",
        f"    Z[{layout.row('rotation') * LANES} + e] = S[{place('angle')} + e]",
        f"    Z[{layout.row('rate') * LANES} + e] = S[{place('rate')} + e]",
        f"equations(Z, S, {place('start')})",
        "start_torques(S)",
    ]
    return f"\n\n{decorator}\ndef begin(Z, S):\n" + "".join(f"    {line}\n" for line in lines)


def _iterate(layout: Layout) -> str:
    decorator = DECORATOR.format(signature="void(float64[::1], float64[::1], float32[::1], int64)")
    lines = []
    rates = [f"S[{place('stage_rate', i * MOST_STAGED)} + e]" for i in range(STAGES)]
    for i in range(STAGES):
        turned = " + ".join(f"{float(INTEGRAL[i, m])!r} * {rates[m]}" for m in range(STAGES))
        lines += [
            f"for e in range({layout.n * LANES}):",
            f"    swept = S[{place('step')} + e] * ({turned})",
            f"    Z[{layout.row('rotation') * LANES} + e] = S[{place('angle')} + e] + swept",
            f"    Z[{layout.row('rate') * LANES} + e] = {rates[i]}",
            f"equations(Z, S, {place('stages', i * EVALUATED)})",
        ]
    lines += ["if fresh != 0:", "    to_single(S, L)", "    average_slopes(L)", "    factorise_stages(L)"]
    lines += ["average_torques(S)", "find_residuals(S, L)", "solve_stages(L)", "change_stages(S, L)"]
    return f"\n\n{decorator}\ndef iterate(Z, S, L, fresh):\n" + "".join(f"    {line}\n" for line in lines)


def _at(block: str, row: int) -> str:
    return f"S[{place(block, row)} + l]"


def _single_at(block: str, row: int) -> str:
    return f"L[{single_place(block, row)} + l]"


def _joint_loop(name: str, n: int, lines: list[str], array: str = "S") -> str:
    """Source of a function of one array that executes these lines for each joint and lane."""
    body = "\n".join(f"            {line}" for line in lines)
    head = f"\n\n{_INNER}\ndef {name}({array}):\n    for j in range({n}):\n"
    return head + f"        for l in range({LANES}):\n            e = j * {LANES} + l\n{body}\n"


def _of_joint(block: str, row: int = 0) -> str:
    """Entry of joint ``j`` in a block with a row a joint; ``row`` : first row of the quantity."""
    return f"S[{place(block, row)} + e]"


def _torques(count: int) -> list[str]:
    """Lines that set ``f{k}`` to the torque of the curve at each of the speeds ``v{k}``."""
    lines = [f"c = j * {CURVE_POINTS * LANES} + l"]
    for k in range(count):
        lines += [f"a{k} = abs(v{k})", f"f{k} = 0.0"]
    for m in range(CURVE_POINTS):
        lines += [f"s = S[{place('curve_speed', m)} + c]", f"g = S[{place('curve_slope', m)} + c]"]
        lines += [f"f{k} += g * min(s, a{k})" for k in range(count)]
    return lines + [f"f{k} = f{k} if v{k} > 0.0 else -f{k}" for k in range(count)]


def _average_torques() -> list[str]:
    """Lines of ``average_torques``: integrals over the step, by its length, of the torque times the stages."""
    lines = [f"w{i} = {_of_joint('stage_rate', i * MOST_STAGED)}" for i in range(STAGES)]
    for k in range(AVERAGED):
        lines.append(f"v{k} = " + " + ".join(f"{float(AT_SHARES[k, i])!r} * w{i}" for i in range(STAGES)))
    lines += _torques(AVERAGED)
    for i in range(STAGES):
        terms = [f"{float(SHARE_WEIGHTS[k] * AT_SHARES[k, i])!r} * f{k}" for k in range(AVERAGED)]
        lines.append(f"{_of_joint('torque', i * MOST_STAGED)} = {' + '.join(terms)}")
    return lines


def _to_single(n: int) -> str:
    """Source of ``to_single(S, L)``, which copies what Newton's matrix is made of, but for the slopes."""
    lines, joints = [], f"for e in range({n * LANES}):"
    for i in range(STAGES):
        rate = f"L[{single_place('stage_rate', i * MOST_STAGED)} + e]"
        lines += [joints, f"    {rate} = single(S[{place('stage_rate', i * MOST_STAGED)} + e])"]
        mass = f"L[{single_place('stages', i * MASSES)} + e]"
        lines += [f"for e in range({n * (n + 1) // 2 * LANES}):"]
        lines += [f"    {mass} = single(S[{place('stages', i * EVALUATED)} + e])"]
    lines += [joints, f"    h = S[{place('step')} + e]"]
    lines += [f"    L[{single_place('damper')} + e] = single(h * S[{place('damper')} + e])"]
    lines += [f"    L[{single_place('spring')} + e] = single(h * h * S[{place('spring')} + e])"]
    lines += [f"for l in range({LANES}):", f"    {_single_at('step', 0)} = single({_at('step', 0)})"]
    return f"\n\n{_INNER}\ndef to_single(S, L):\n" + "".join(f"    {line}\n" for line in lines)


def _average_slopes() -> list[str]:
    """Lines of ``average_slopes``: integrals over the step, by its length, of the slope times two stages."""
    zero = _single(0.0)
    lines = [f"w{i} = L[{single_place('stage_rate', i * MOST_STAGED)} + e]" for i in range(STAGES)]
    for k in range(AVERAGED):
        terms = [f"{_single(AT_SHARES[k, i])} * w{i}" for i in range(STAGES)]
        lines += [f"a{k} = abs({' + '.join(terms)})", f"d{k} = {zero}"]
    lines.append(f"c = j * {CURVE_POINTS * LANES} + l")
    for m in range(CURVE_POINTS):
        lines.append(f"s, g = L[{single_place('curve_speed', m)} + c], L[{single_place('curve_slope', m)} + c]")
        lines += [f"d{k} += g if a{k} < s else {zero}" for k in range(AVERAGED)]
    for i in range(STAGES):
        for m in range(i, STAGES):
            weight = SHARE_WEIGHTS * AT_SHARES[:, i] * AT_SHARES[:, m]
            terms = [f"{_single(weight[k])} * d{k}" for k in range(AVERAGED)]
            lines.append(f"L[{single_place('slope', pair(i, m) * MOST_STAGED)} + e] = {' + '.join(terms)}")
    return lines


def _at_start() -> list[str]:
    """Lines of ``start_torques``: torque and slope at the start of the step."""
    lines = [f"v0 = {_of_joint('rate')}", *_torques(1), "d0 = 0.0"]
    for m in range(CURVE_POINTS):
        lines.append(f"d0 += S[{place('curve_slope', m)} + c] if a0 < S[{place('curve_speed', m)} + c] else 0.0")
    return [*lines, f"{_of_joint('start_torque')} = f0", f"{_of_joint('start_slope')} = d0"]


def _equations(layout: Layout) -> list[str]:
    """Lines of ``equations``: mass matrix and joint torques, to ``S`` from the index ``base`` on."""
    n, lines = layout.n, equations_of_motion(layout)
    for i in range(n):
        lines.append(f"S[(base & {PLACE}) + {(MASSES + i) * LANES} + l] = r{i}")
        rows = {j: mass_entry(i, j, n) for j in range(i, n)}
        lines += [f"S[(base & {PLACE}) + {row * LANES} + l] = J{i}{j}" for j, row in rows.items()]
    return lines


def _factorise(n: int) -> list[str]:
    """Lines of ``factorise_stages``: Newton's matrix for the rates of all stages, eliminated.

    Row (i, a) is stage i's equation of joint a times the stage's weight, which makes the damper's part symmetric and
    the symmetric part of the whole positive definite, so that no pivoting is needed (Golub & Van Loan, *Matrix
    Computations*, 4th ed., section 4.3.2; elimination: algorithm 3.2.1). Single precision takes half the time; it
    limits how much one iteration corrects, a part in 1e6, not the result.
    """
    size = STAGES * n
    lines = [f"h = {_single_at('step', 0)}"]
    for a in range(n):
        lines += [f"k{a} = {_single_at('spring', a)}", f"b{a} = {_single_at('damper', a)}"]
    for i in range(STAGES):
        masses = [(a, b) for a in range(n) for b in range(a, n)]
        lines += [f"m{a}{b} = {_single_at('stages', i * MASSES + mass_entry(a, b, n))}" for a, b in masses]
        for a in range(n):
            for m in range(STAGES):
                for b in range(n):
                    entry = f"{_single(WEIGHTS[i] * INVERSE[i, m])} * m{min(a, b)}{max(a, b)}"
                    if a == b:
                        entry += f" + h * {_single_at('slope', pair(i, m) * MOST_STAGED + a)}"
                        entry += f" + {_single(WEIGHTS[i] * INTEGRAL[i, m])} * k{a}"
                        entry += f" + {_single(WEIGHTS[i])} * b{a}" if i == m else ""
                    lines.append(f"K{i * n + a}_{m * n + b} = {entry}")
    for p in range(size):
        lines += [f"I = {_single(1.0)} / K{p}_{p}", f"{_factor(p, p, size)} = I"]
        lines += [f"{_factor(p, c, size)} = K{p}_{c}" for c in range(p + 1, size)]
        for r in range(p + 1, size):
            lines += [f"f = K{r}_{p} * I", f"{_factor(r, p, size)} = f"]
            lines += [f"K{r}_{c} -= f * K{p}_{c}" for c in range(p + 1, size)]
    return lines


def _single(value: float) -> str:
    """A constant of single precision."""
    return f"single({float(value)!r})"


def _factor(r: int, c: int, size: int) -> str:
    return f"L[{(r * size + c) * LANES} + l]"


def _masses(i: int, n: int) -> list[str]:
    """Lines that set ``m{a}{b}`` to stage i's mass matrix."""
    return [f"m{a}{b} = {_at('stages', i * EVALUATED + mass_entry(a, b, n))}" for a in range(n) for b in range(a, n)]


def _residuals(n: int) -> list[str]:
    """Lines of ``find_residuals``: of the stages' equations times the stages' weights."""
    lines = [f"h = S[{place('step')} + l]"]
    for a in range(n):
        lines.append(f"w{a} = {_at('rate', a)}")
        lines += [f"W{i}{a} = {_at('stage_rate', i * MOST_STAGED + a)} - w{a}" for i in range(STAGES)]
    for i in range(STAGES):
        lines += _masses(i, n)
        for b in range(n):
            terms = [f"{float(WEIGHTS[i] * INVERSE[i, m])!r} * W{m}{b}" for m in range(STAGES)]
            lines.append(f"x{b} = {' + '.join(terms)}")
        for a in range(n):
            moved = " - ".join(f"m{min(a, b)}{max(a, b)} * x{b}" for b in range(n))
            force = f"{float(WEIGHTS[i])!r} * {_at('stages', i * EVALUATED + MASSES + a)}"
            value = f"h * ({force} - {_at('torque', i * MOST_STAGED + a)}) - {moved}"
            lines.append(f"{_single_at('residual', i * n + a)} = single({value})")
    return lines


def _solve(n: int) -> list[str]:
    """Lines of ``solve_stages``: the changes of the stages' rates by one Newton iteration, with the matrix there is."""
    size, lines = STAGES * n, []
    for r in range(size):
        known = "".join(f" - {_factor(r, c, size)} * Y{c}" for c in range(r))
        lines.append(f"Y{r} = {_single_at('residual', r)}{known}")
    for r in range(size - 1, -1, -1):
        known = "".join(f" - {_factor(r, c, size)} * X{c}" for c in range(r + 1, size))
        lines.append(f"X{r} = (Y{r}{known}) * {_factor(r, r, size)}")
    return lines + [f"{_single_at('residual', r)} = X{r}" for r in range(size)]


def _change(n: int) -> list[str]:
    """Lines of ``change_stages``: change the stages' rates, and find the largest change."""
    lines = [f"scale{a} = 1.0 / (1.0 + abs({_at('rate', a)}))" for a in range(n)]
    lines.append("change = 0.0")
    for i in range(STAGES):
        for a in range(n):
            lines.append(f"x = float({_single_at('residual', i * n + a)})")
            lines.append(f"{_at('stage_rate', i * MOST_STAGED + a)} += x")
            lines.append(f"change = max(change, abs(x) * scale{a})")
    return [*lines, f"S[{place('change')} + l] = change"]


def _filter(n: int) -> list[str]:
    """Lines of ``filter_error``: the estimated error by the implicit part of the equations, of rates by their scale."""
    lines = [f"h = S[{place('step')} + l]", f"g = {FILTER!r} * h"]
    for a in range(n):
        lines.append(f"w{a} = {_at('rate', a)}")
        lines += [f"W{i}{a} = {_at('stage_rate', i * MOST_STAGED + a)}" for i in range(STAGES)]
        spread = [f"{float((ERROR @ INTEGRAL)[m])!r} * W{m}{a}" for m in range(STAGES)]
        lines.append(f"u{a} = g * w{a} + h * ({' + '.join(spread)})")
        lines.append(f"v{a} = " + " + ".join(f"{float(ERROR[i])!r} * (W{i}{a} - w{a})" for i in range(STAGES)))
    for a in range(n):
        for b in range(a, n):
            lines.append(f"m{a}{b} = {_at('start', mass_entry(a, b, n))}")
            lines.append(f"J{a}{b} = m{a}{b}")
        ends = [(i, m) for i in range(STAGES) for m in range(STAGES)]
        mean = " + ".join(f"float({_single_at('slope', pair(i, m) * MOST_STAGED + a)})" for i, m in ends)
        steep = f"max({_at('start_slope', a)}, {mean})"
        lines.append(f"J{a}{a} += g * ({_at('damper', a)} + {steep}) + g * g * {_at('spring', a)}")
        least = _at("start_slope", a)
        for i in range(STAGES):
            slope = f"float({_single_at('slope', pair(i, i) * MOST_STAGED + a)})"
            least = f"min({least}, {float(1.0 / WEIGHTS[i])!r} * {slope})"
        lines.append(f"d{a} = {_at('damper', a)} + {least}")
    for a in range(n):
        force = f"{_at('start', MASSES + a)} - {_at('start_torque', a)} - {_at('spring', a)} * u{a}"
        moved = " + ".join(f"m{min(a, b)}{max(a, b)} * v{b}" for b in range(n))
        lines.append(f"r{a} = g * ({force}) + {moved}")
    lines += [f"scale{a} = {RATE_SCALE!r} + {DAMPED!r} * d{a} / m{a}{a}" for a in range(n)]
    lines += solve(n, ("e", [f"r{a}" for a in range(n)]))
    for a in range(n):
        lines += [f"{_at('rate_error', a)} = e{a} / scale{a}", f"{_at('angle_error', a)} = u{a} + g * e{a}"]
    return lines
