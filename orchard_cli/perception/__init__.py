"""Depth, radar, range, images -> obstacles."""

from .mount import Mount
from .realsense import Found, RealSense, RealSenseSettings, find

__all__ = ["Found", "Mount", "RealSense", "RealSenseSettings", "find"]
