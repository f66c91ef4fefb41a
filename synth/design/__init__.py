"""From an animal's motion to a leg of parts: fit, choose parts, fit again with them, simulate and draw the result."""
