"""Flying a mission: states, safety, the loop, and the sockets that equipment fits."""
