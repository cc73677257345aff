"""Depth, radar, range, images -> obstacles."""

from .depth_detector import DepthDetector, DepthDetectorSettings
from .eyes import EyesSettings, RgbdEyes
from .mount import Mount
from .realsense import Found, RealSense, RealSenseSettings, find

__all__ = [
    "DepthDetector",
    "DepthDetectorSettings",
    "EyesSettings",
    "Found",
    "Mount",
    "RealSense",
    "RealSenseSettings",
    "RgbdEyes",
    "find",
]
