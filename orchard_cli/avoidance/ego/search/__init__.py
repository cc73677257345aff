"""The way round an obstacle."""
