"""Records <-> MCAP."""
