"""The door: one file per verb; wiring.py plugs the sockets."""
