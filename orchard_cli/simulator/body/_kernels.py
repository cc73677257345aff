"""Kernels of the simulated vehicle's body: rotors, drag, ground, and the step in time.

Site frame and body FLU, SI and radians. Layouts of the flat arrays:

state (17)    0 position, 3 velocity, 6 site_from_body (w, x, y, z), 10 body rates, 13 rotor speeds
around (6)    0 wind (towards), 3 the ground plane a, b, c: z = a x + b y + c
air (7)       0 mean wind, 3 gust along x and y m/s, 5 what is kept of it, 6 what is added
load (5)      mass kg, Ixx, Iyy, Izz kg m², height m of the rotors over the centre of mass
airframe (11) the constants below

Rotors: 0 front right and 1 back left turn counter-clockwise, 2 front left and 3 back right
clockwise, seen from above.
"""

import numpy as np
from numba import njit

GRAVITY = 9.80665

K_THRUST, K_MOMENT, ARM, LAG, SPEED_MAX, SPEED_IDLE = 0, 1, 2, 3, 4, 5
DRAG_ROTOR, DRAG_BODY, GROUND_SPRING, GROUND_DAMPER, FRICTION = 6, 7, 8, 9, 10


@njit(cache=True, nogil=True)
def blow(air, normals, around):
    """The next gust: a first-order Gauss-Markov process driven by `normals` (2,)."""
    for i in range(2):
        air[3 + i] = air[5] * air[3 + i] + air[6] * normals[i]
        around[i] = air[i] + air[3 + i]
    around[2] = air[2]


@njit(cache=True, nogil=True)
def derivative(state, speeds_wanted, around, load, airframe, out):
    w, x, y, z = state[6], state[7], state[8], state[9]
    r00, r01, r02 = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    r10, r11, r12 = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    r20, r21, r22 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    p, q, r = state[10], state[11], state[12]

    # Rotors: thrust up, arms, and the reaction of each rotor's drag against its own sense.
    f0 = airframe[K_THRUST] * state[13] ** 2
    f1 = airframe[K_THRUST] * state[14] ** 2
    f2 = airframe[K_THRUST] * state[15] ** 2
    f3 = airframe[K_THRUST] * state[16] ** 2
    tx = airframe[ARM] * (-f0 + f1 + f2 - f3)
    ty = airframe[ARM] * (-f0 + f1 - f2 + f3)
    tz = airframe[K_MOMENT] * (-f0 - f1 + f2 + f3)
    thrust = f0 + f1 + f2 + f3

    # Drag against the air: of the rotors in their plane, and of the body.
    ax, ay, az = state[3] - around[0], state[4] - around[1], state[5] - around[2]
    spin = airframe[DRAG_ROTOR] * (state[13] + state[14] + state[15] + state[16])
    bx = -spin * (r00 * ax + r10 * ay + r20 * az)
    by = -spin * (r01 * ax + r11 * ay + r21 * az)
    tx -= load[4] * by
    ty += load[4] * bx
    body = airframe[DRAG_BODY] * np.sqrt(ax * ax + ay * ay + az * az)
    fx = r00 * bx + r01 * by + r02 * thrust - body * ax
    fy = r10 * bx + r11 * by + r12 * thrust - body * ay
    fz = r20 * bx + r21 * by + r22 * thrust - body * az

    # Ground: four feet below the rotors, each a spring and damper with friction. It is taken as
    # level under each foot: orchards that can be sprayed by one plane are nearly flat.
    arm = airframe[ARM]
    height = state[2] - around[3] * state[0] - around[4] * state[1] - around[5]
    if height < 2 * arm:
        for foot in range(4):
            lx = arm if foot in (0, 2) else -arm
            ly = -arm if foot in (0, 3) else arm
            depth = -(height + r20 * lx + r21 * ly)
            if depth <= 0:
                continue
            sx, sy, sz = -r * ly, r * lx, p * ly - q * lx  # rates x arm
            vx = state[3] + r00 * sx + r01 * sy + r02 * sz
            vy = state[4] + r10 * sx + r11 * sy + r12 * sz
            vz = state[5] + r20 * sx + r21 * sy + r22 * sz
            push = airframe[GROUND_SPRING] * depth - airframe[GROUND_DAMPER] * vz
            push = max(push, 0.0)
            slide = np.sqrt(vx * vx + vy * vy)
            grip = airframe[GROUND_DAMPER]
            if grip * slide > airframe[FRICTION] * push:
                grip = airframe[FRICTION] * push / slide
            gx, gy = -grip * vx, -grip * vy
            fx += gx
            fy += gy
            fz += push
            cx = r00 * gx + r10 * gy + r20 * push
            cy = r01 * gx + r11 * gy + r21 * push
            cz = r02 * gx + r12 * gy + r22 * push
            tx += ly * cz
            ty -= lx * cz
            tz += lx * cy - ly * cx

    out[0], out[1], out[2] = state[3], state[4], state[5]
    out[3], out[4], out[5] = fx / load[0], fy / load[0], fz / load[0] - GRAVITY
    out[6] = 0.5 * (-x * p - y * q - z * r)
    out[7] = 0.5 * (w * p + y * r - z * q)
    out[8] = 0.5 * (w * q - x * r + z * p)
    out[9] = 0.5 * (w * r + x * q - y * p)
    out[10] = (tx - (load[3] - load[2]) * q * r) / load[1]
    out[11] = (ty - (load[1] - load[3]) * p * r) / load[2]
    out[12] = (tz - (load[2] - load[1]) * p * q) / load[3]
    for i in range(4):
        out[13 + i] = (speeds_wanted[i] - state[13 + i]) / airframe[LAG]


@njit(cache=True, nogil=True)
def rk4(state, speeds_wanted, around, load, airframe, dt, work):
    """Advance `state` by `dt` in place; `work` is (5, 17)."""
    derivative(state, speeds_wanted, around, load, airframe, work[0])
    for k in range(3):
        step = dt if k == 2 else 0.5 * dt
        for i in range(17):
            work[4, i] = state[i] + step * work[k, i]
        derivative(work[4], speeds_wanted, around, load, airframe, work[k + 1])
    for i in range(17):
        state[i] += dt / 6 * (work[0, i] + 2 * work[1, i] + 2 * work[2, i] + work[3, i])
    norm = np.sqrt(state[6] ** 2 + state[7] ** 2 + state[8] ** 2 + state[9] ** 2)
    for i in range(6, 10):
        state[i] /= norm
