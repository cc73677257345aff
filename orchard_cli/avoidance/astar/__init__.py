"""The `astar` system: improved A* on a map, after Huang et al. 2021."""
