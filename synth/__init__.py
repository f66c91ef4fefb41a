"""From recorded limb motion to springs, dampers and joints, and why the built limb moves differently."""

__version__ = "0.2.0"
