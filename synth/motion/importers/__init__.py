"""Motion that other programs recorded: one module a format, giving ``Channels`` (angles) or ``Markers`` (points)."""
