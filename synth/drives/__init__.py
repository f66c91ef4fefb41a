"""Motors, gears and servos: what drives a joint, as data and as a compiled law, for every plant."""
