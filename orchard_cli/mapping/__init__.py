"""The rolling occupancy grid and its distance field."""
