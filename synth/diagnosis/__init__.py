"""Why the built leg moves differently from the simulated one: where, which effect, how far it shrinks, what next."""
