"""From an animal's motion to a leg of parts: fit, choose, fit again, wind, and what comes of it."""
