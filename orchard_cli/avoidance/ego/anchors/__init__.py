"""Pairs of a surface point and a direction that push the curve off obstacles, found by A*."""
