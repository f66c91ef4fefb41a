"""Common units with size and dimension, so that pint need not be loaded.

Loading pint and its registry takes more than a tenth of a second; a test compares each line with them.
"""

from __future__ import annotations

from math import pi

Dimension = tuple[tuple[str, float], ...]

_LBF = 0.45359237 * 9.80665  # N, NIST SP 811 (2008), appendix B
_SIZES = {
    "degree": pi / 180,  # rad
    "rpm": 2 * pi / 60,  # rad/s
    "lbf": _LBF,
    "inlbf": 0.0254 * _LBF,  # N m
    "inozf": 0.0254 * _LBF / 16,  # N m
    "inlbfdeg": 0.0254 * _LBF / (pi / 180),  # N m/rad
}
# unit, size in SI, powers of the dimensions
_LINES = """
percent         0.01    -
m               1       length
cm              0.01    length
mm              0.001   length
in              0.0254  length
kg              1       mass
g               0.001   mass
s               1       time
ms              0.001   time
Hz              1       time^-1
kHz             1000    time^-1
rad             1       angle
deg             degree  angle
rad/s           1       angle time^-1
deg/s           degree  angle time^-1
rpm             rpm     angle time^-1
rad/s^2         1       angle time^-2
m/s             1       length time^-1
m/s^2           1       length time^-2
s/m             1       length^-1 time
s/rad           1       angle^-1 time
1/rad           1       angle^-1
lb              0.45359237  mass
oz              0.028349523125  mass
ft              0.3048  length
lbf             lbf     length mass time^-2
in*lbf          inlbf   length^2 mass time^-2
in*ozf          inozf   length^2 mass time^-2
ozf*in          inozf   length^2 mass time^-2
lbf*in/deg      inlbfdeg    angle^-1 length^2 mass time^-2
in*lbf/rad      inlbf   angle^-1 length^2 mass time^-2
in*lbf*s/rad    inlbf   angle^-1 length^2 mass time^-1
kg/m            1       length^-1 mass
kg*m^2          1       length^2 mass
kg*cm^2         0.0001  length^2 mass
g*mm^2          1e-09   length^2 mass
kg/m^3          1       length^-3 mass
N               1       length mass time^-2
N/m             1       mass time^-2
N/mm            1000    mass time^-2
N*s/m           1       mass time^-1
N*m             1       length^2 mass time^-2
N*mm            0.001   length^2 mass time^-2
mN*m            0.001   length^2 mass time^-2
N*m^2           1       length^3 mass time^-2
N*m/A           1       current^-1 length^2 mass time^-2
V/(rad/s)       1       angle^-1 current^-1 length^2 mass time^-2
J               1       length^2 mass time^-2
N*m/rad         1       angle^-1 length^2 mass time^-2
N*mm/rad        0.001   angle^-1 length^2 mass time^-2
N*m*s/rad       1       angle^-1 length^2 mass time^-1
N*m*s^2/rad^2   1       angle^-2 length^2 mass
N*m/rad^3       1       angle^-3 length^2 mass time^-2
Pa              1       length^-1 mass time^-2
MPa             1e6     length^-1 mass time^-2
GPa             1e9     length^-1 mass time^-2
W               1       length^2 mass time^-3
A               1       current
mA              0.001   current
V               1       current^-1 length^2 mass time^-3
ohm             1       current^-2 length^2 mass time^-3
H               1       current^-2 length^2 mass time^-2
mH              0.001   current^-2 length^2 mass time^-2
bit             1       information
K               1       temperature
"""


def _dimension(powers: list[str]) -> Dimension:
    parts = [power.partition("^") for power in powers if power != "-"]
    return tuple((f"[{name}]", float(exponent or 1)) for name, _, exponent in parts)


OFTEN: dict[str, tuple[float, Dimension]] = {
    unit: (_SIZES.get(size) or float(size), _dimension(powers))
    for unit, size, *powers in (line.split() for line in _LINES.strip().splitlines())
}
