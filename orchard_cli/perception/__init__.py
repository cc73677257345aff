"""Depth, radar, range, images -> obstacles."""

from .depth_detector import DepthDetector, DepthDetectorSettings
from .eyes import EyesSettings, RgbdEyes
from .mount import Mount
from .onnx_detector import OnnxDetector, OnnxSettings
from .realsense import Found, RealSense, RealSenseSettings, find

__all__ = [
    "DepthDetector",
    "DepthDetectorSettings",
    "EyesSettings",
    "Found",
    "Mount",
    "OnnxDetector",
    "OnnxSettings",
    "RealSense",
    "RealSenseSettings",
    "RgbdEyes",
    "find",
]
