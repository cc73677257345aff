"""Unit quaternions (w, x, y, z), Hamilton's product, rotating body vectors into the site frame.

`site_from_body` turned by these functions rhymes: `site_from_a = multiply(site_from_b, b_from_a)`.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
IDENTITY.setflags(write=False)


def normalised(quaternion: Vector) -> Vector:
    """The unit quaternion along `quaternion`. Raises ValueError when it has no length."""
    length = float(np.linalg.norm(quaternion))
    if not (math.isfinite(length) and length > 1e-9):
        raise ValueError("a quaternion without length turns nothing")
    return np.asarray(quaternion, dtype=np.float64) / length


def multiply(a_from_b: Vector, b_from_c: Vector) -> Vector:
    """a_from_c: first the right turn, then the left one."""
    aw, ax, ay, az = a_from_b
    bw, bx, by, bz = b_from_c
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def inverse(a_from_b: Vector) -> Vector:
    """b_from_a, of a unit quaternion."""
    w, x, y, z = a_from_b
    return np.array([w, -x, -y, -z])


def matrix(a_from_b: Vector) -> Array:
    """The (3, 3) rotation of a unit quaternion: `v_a = matrix(a_from_b) @ v_b`."""
    w, x, y, z = a_from_b
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotate(a_from_b: Vector, vectors_b: Points) -> Points:
    """Vectors (3,) or (n, 3) of frame b, written in frame a."""
    return np.asarray(vectors_b, dtype=np.float64) @ matrix(a_from_b).T


def from_yaw_pitch_roll(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Vector:
    """site_from_body of a body turned by yaw about z, pitch about its y, roll about its x.

    Radians, right-handed, body x forward, y left, z up: positive yaw turns the nose left,
    positive pitch lowers the nose, positive roll lowers the right side.
    """
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def slerp(start: Vector, end: Vector, share: float) -> Vector:
    """The turn `share` (0 to 1) of the way from one unit quaternion to another, the short way."""
    dot = float(np.dot(start, end))
    if dot < 0.0:  # q and -q are the same turn
        end, dot = -np.asarray(end), -dot
    if dot > 1.0 - 1e-9:
        return normalised((1 - share) * np.asarray(start) + share * np.asarray(end))
    angle = math.acos(dot)
    first, second = math.sin((1 - share) * angle), math.sin(share * angle)
    return normalised((first * np.asarray(start) + second * np.asarray(end)) / math.sin(angle))
