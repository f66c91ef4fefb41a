"""Motors, gears and servos that drive a joint, as data and as a compiled law for every plant."""
