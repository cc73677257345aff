"""The avoidance systems, each fits the socket `Avoidance` in flight/ports.py."""
