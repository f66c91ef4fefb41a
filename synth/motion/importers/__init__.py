"""Importers of motion recorded by other programs: one module per format, giving ``Channels`` or ``Markers``."""
