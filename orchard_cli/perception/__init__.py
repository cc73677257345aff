"""Depth, radar, range, images -> obstacles."""
