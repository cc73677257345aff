"""Frames, geodesy, polygons."""
