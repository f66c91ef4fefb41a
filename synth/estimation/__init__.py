"""Estimation independent of any leg: priors, normal equations, Levenberg-Marquardt, information."""
