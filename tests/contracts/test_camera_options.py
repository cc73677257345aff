"""What a pilot may say of the camera, and what is refused with its mend."""

from __future__ import annotations

import math

import pytest

from orchard_cli.commands.camera_options import camera_filters, camera_mode, camera_mount
from orchard_cli.errors import InputError


def test_a_mount_is_metres_and_degrees_down() -> None:
    assert camera_mount("0.12, 0, -0.05, 30") == (0.12, 0.0, -0.05, math.radians(30))


@pytest.mark.parametrize("text", ["", "1,2,3", "a,b,c,d", "nan,0,0,0", "0,0,0,90", "12,0,0,0"])
def test_a_place_that_no_airframe_has_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--camera-mount"):
        camera_mount(text)


def test_filters_are_named() -> None:
    assert camera_filters("") == ()
    assert camera_filters("spatial, holes") == ("spatial", "holes")
    with pytest.raises(InputError, match="temporal"):
        camera_filters("temporal")


def test_a_mode_is_the_cameras() -> None:
    assert camera_mode("848x480") == (848, 480)
    with pytest.raises(InputError, match="--camera"):
        camera_mode("800x600")
