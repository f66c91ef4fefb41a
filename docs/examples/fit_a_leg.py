"""From a leg made in code and its recordings to springs and dampers, as a table, a figure and a folder of files."""

from pathlib import Path

import synth

HERE = Path(__file__).parent
EXAMPLE = Path(synth.__file__).parent / "examples" / "fit"  # what `synth init fit` copies

leg = synth.read_leg(EXAMPLE / "robot.leg.yaml")
trials = synth.read_trials(["trials/free_*.csv"], leg, folder=EXAMPLE)

found = synth.fit(leg, trials)
print(found.headline)
print(found.to_frame().round(4).to_string(index=False))

# Each estimate has a value and the ends of its 90 % interval, in SI units.
for name, joint in found.joints.items():
    rate = joint.spring_rate
    print(f"{name}: {rate.value:.3g} N*m/rad, 90 % between {rate.low:.3g} and {rate.high:.3g}")
