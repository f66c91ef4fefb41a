"""Estimation that knows no leg: priors, normal equations, Levenberg-Marquardt, information."""
