"""The cost of a curve and its minimiser."""
