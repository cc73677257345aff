"""Curves in space and time: fitting, timing, searching and optimising. No orchard words."""
