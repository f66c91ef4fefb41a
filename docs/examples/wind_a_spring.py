"""The torsion spring to wind for a rate and a travel, over all stock wire; what to do where there is none."""

import math

import synth

found = synth.spring("1.7 Nm/rad", "40 deg", wish={"included_angle": math.radians(120)})
print(found.headline)
print(found.to_frame().round(3).to_string(index=False))

# That a spring cannot be had is an answer, not an error.
none = synth.spring("79 N*m/rad", "170 deg")
print(none.headline)
for reason in none.in_the_way:
    print(" -", reason)
