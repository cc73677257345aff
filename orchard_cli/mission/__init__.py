"""Orchard and settings -> Mission: route, spline, time law, checks, files."""
