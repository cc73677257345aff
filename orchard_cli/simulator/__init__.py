"""The embedded simulator: world, renderer, body, autopilot (MAVLink)."""
