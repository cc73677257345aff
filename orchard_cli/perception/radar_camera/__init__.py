"""Radar and camera as one sensor (Huang 2021, §2.2 and §2.3): distance and contour of a thing."""

from .sensor import RadarCamera, RadarCameraSettings

__all__ = ["RadarCamera", "RadarCameraSettings"]
