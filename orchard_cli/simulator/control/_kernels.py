"""Kernels of PX4's control cascade, z up: position, velocity, attitude, rates, mixer.

Site frame and body FLU, SI and radians. Layouts of the flat arrays (and those of body/_kernels):

setpoint (11) 0 position, 3 velocity, 6 acceleration, 9 yaw, 10 yaw rate; NaN is not controlled
limits (5)    horizontal speed, climb, descent m/s, tilt rad, least collective (share of maximum)
error (9)     what the estimate adds to the truth: position, velocity, small turn in the site frame
gains (34)    the constants below; each of the first nine names a triple
memory (24)   0 velocity integral, 3 rate integral, 6 last rates, 9 angular acceleration,
              12 last velocity, 15 acceleration, 18 attitude setpoint, 22 collective, 23 yaw rate
"""

import numpy as np
from numba import njit

from orchard_cli.simulator.body._kernels import GRAVITY, SPEED_IDLE, SPEED_MAX, rk4

P_POSITION, P_VELOCITY, I_VELOCITY, D_VELOCITY = 0, 3, 6, 9
P_ATTITUDE, P_RATE, I_RATE, D_RATE, RATE_MAX = 12, 15, 18, 21, 24
I_RATE_MAX, YAW_WEIGHT, HOVER, COLLECTIVE_MAX, MARGIN_XY, CUT_VELOCITY, CUT_RATE = range(27, 34)

OFF, IDLE, FLYING = 0, 1, 2


@njit(cache=True, nogil=True)
def _limit_horizontal(first, velocity, limit):
    """Keep |velocity| under `limit`, giving way to its part `first` (PX4 constrainXY)."""
    if np.hypot(velocity[0], velocity[1]) <= limit:
        return
    sx, sy = velocity[0] - first[0], velocity[1] - first[1]
    first_size, second_size = np.hypot(first[0], first[1]), np.hypot(sx, sy)
    if first_size >= limit or second_size < 1e-3:
        scale = limit / max(first_size, 1e-9)
        velocity[0], velocity[1] = first[0] * scale, first[1] * scale
        return
    ux, uy = sx / second_size, sy / second_size
    along = ux * first[0] + uy * first[1]
    reach = -along + np.sqrt(along * along - first_size * first_size + limit * limit)
    velocity[0], velocity[1] = first[0] + ux * reach, first[1] + uy * reach


@njit(cache=True, nogil=True)
def _limit_tilt(up, limit):
    """Turn the unit vector `up` towards the vertical until it leans by at most `limit`."""
    lean = np.hypot(up[0], up[1])
    if np.arctan2(lean, up[2]) > limit:
        scale = np.sin(limit) / max(lean, 1e-9)
        up[0], up[1], up[2] = up[0] * scale, up[1] * scale, np.cos(limit)


@njit(cache=True, nogil=True)
def control_position(position, velocity, yaw, setpoint, limits, gains, dt, memory):
    """PX4's PositionControl, z up: fills the attitude setpoint and the collective in `memory`."""
    wanted, first, push = np.empty(3), np.zeros(3), np.empty(3)
    for i in range(3):
        wanted[i] = setpoint[3 + i]
        if np.isfinite(setpoint[i]):
            first[i] = (setpoint[i] - position[i]) * gains[P_POSITION + i]
            wanted[i] = wanted[i] + first[i] if np.isfinite(wanted[i]) else first[i]
    if np.isfinite(wanted[0]) and np.isfinite(wanted[1]):
        _limit_horizontal(first, wanted, limits[0])
    if np.isfinite(wanted[2]):
        wanted[2] = min(max(wanted[2], -limits[2]), limits[1])

    miss = np.zeros(3)
    for i in range(3):
        push[i] = setpoint[6 + i] if np.isfinite(setpoint[6 + i]) else 0.0
        if np.isfinite(wanted[i]):
            miss[i] = wanted[i] - velocity[i]
            push[i] += gains[P_VELOCITY + i] * miss[i] + memory[i]
            push[i] -= gains[D_VELOCITY + i] * memory[15 + i]

    # Thrust along the wanted force, tilt-limited; climb is decoupled from lean (MPC_ACC_DECOUPLE).
    hover, most, least = gains[HOVER], gains[COLLECTIVE_MAX], limits[4]
    up = np.array([push[0], push[1], GRAVITY])
    up /= np.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2)
    _limit_tilt(up, limits[3])
    collective = max((push[2] / GRAVITY + 1.0) * hover / up[2], least)
    thrust = up * collective
    if (thrust[2] <= least and miss[2] <= 0) or (thrust[2] >= most and miss[2] >= 0):
        miss[2] = 0.0
    # Height first, but keep a margin for the horizontal.
    side = np.hypot(thrust[0], thrust[1])
    kept = min(side, gains[MARGIN_XY])
    thrust[2] = min(thrust[2], np.sqrt(most * most - kept * kept))
    side_max = np.sqrt(most * most - thrust[2] ** 2)
    if side > side_max:
        thrust[0] *= side_max / side
        thrust[1] *= side_max / side
    # Wind-up: bleed the horizontal integral by what could not be produced.
    made_x, made_y = thrust[0] * GRAVITY / hover, thrust[1] * GRAVITY / hover
    if push[0] ** 2 + push[1] ** 2 > made_x**2 + made_y**2:
        miss[0] -= 2.0 / gains[P_VELOCITY] * (push[0] - made_x)
        miss[1] -= 2.0 / gains[P_VELOCITY + 1] * (push[1] - made_y)
    for i in range(3):
        memory[i] += gains[I_VELOCITY + i] * miss[i] * dt
    memory[2] = min(max(memory[2], -GRAVITY), GRAVITY)

    size = np.sqrt(thrust[0] ** 2 + thrust[1] ** 2 + thrust[2] ** 2)
    if size > 1e-6:
        up = thrust / size
    heading = setpoint[9] if np.isfinite(setpoint[9]) else yaw
    left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    nose = np.cross(left, up)
    nose /= np.sqrt(nose[0] ** 2 + nose[1] ** 2 + nose[2] ** 2)
    left = np.cross(up, nose)
    _quaternion(nose, left, up, memory[18:22])
    memory[22] = size
    memory[23] = setpoint[10] if np.isfinite(setpoint[10]) else 0.0


@njit(cache=True, nogil=True)
def _quaternion(nose, left, up, out):
    """Rotation with these columns as a quaternion; `up` never points below the horizon."""
    if nose[0] + left[1] + up[2] > 0:
        s = 2 * np.sqrt(1 + nose[0] + left[1] + up[2])
        out[0], out[1] = s / 4, (left[2] - up[1]) / s
        out[2], out[3] = (up[0] - nose[2]) / s, (nose[1] - left[0]) / s
    else:  # turned by about half a turn about the vertical
        s = 2 * np.sqrt(1 + up[2] - nose[0] - left[1])
        out[0], out[1] = (nose[1] - left[0]) / s, (up[0] + nose[2]) / s
        out[2], out[3] = (left[2] + up[1]) / s, s / 4


@njit(cache=True, nogil=True)
def _product(a, b, out):
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


@njit(cache=True, nogil=True)
def control_attitude(attitude, gains, memory, out):
    """PX4's AttitudeControl (Brescianini 2013), tilt before yaw: fills `out` with wanted rates."""
    conjugate, miss, reduced = attitude.copy(), np.empty(4), np.empty(4)
    conjugate[1:] *= -1.0
    _product(conjugate, memory[18:22], miss)  # body_from_wanted
    if miss[0] < 0:
        miss *= -1.0
    # Split into the tilt (no turn about the body's z) and the yaw that is left: miss = tilt * yaw.
    size = np.hypot(miss[0], miss[3])
    yaw_w, yaw_z = (miss[0] / size, miss[3] / size) if size > 1e-6 else (1.0, 0.0)
    weight = gains[YAW_WEIGHT]
    turn = weight * np.arctan2(yaw_z, yaw_w)
    unyaw = np.array([np.cos(turn), 0.0, 0.0, np.sin(turn)])
    back = np.array([yaw_w, 0.0, 0.0, -yaw_z])
    tilt = np.empty(4)
    _product(miss, back, tilt)
    _product(tilt, unyaw, reduced)
    if reduced[0] < 0:
        reduced *= -1.0
    w, x, y, z = attitude
    vertical = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    for i in range(3):
        gain = gains[P_ATTITUDE + i] / (weight if i == 2 else 1.0)
        rate = 2 * reduced[1 + i] * gain + vertical[i] * memory[23]
        out[i] = min(max(rate, -gains[RATE_MAX + i]), gains[RATE_MAX + i])


@njit(cache=True, nogil=True)
def control_rate(rates, wanted, gains, dt, memory, out):
    """Rate PID to normalised torques, -1 to 1."""
    blend = dt / (dt + 1 / (2 * np.pi * gains[CUT_RATE]))
    for i in range(3):
        memory[9 + i] += blend * ((rates[i] - memory[6 + i]) / dt - memory[9 + i])
        memory[6 + i] = rates[i]
        miss = wanted[i] - rates[i]
        torque = gains[P_RATE + i] * miss + memory[3 + i] - gains[D_RATE + i] * memory[9 + i]
        out[i] = min(max(torque, -1.0), 1.0)
        fade = max(0.0, 1 - (miss / np.radians(400.0)) ** 2)
        integral = memory[3 + i] + fade * gains[I_RATE + i] * miss * dt
        memory[3 + i] = min(max(integral, -gains[I_RATE_MAX]), gains[I_RATE_MAX])


@njit(cache=True, nogil=True)
def mix(collective, torque, airframe, speeds):
    """Rotor speeds for a collective and torques; roll and pitch before height, yaw last."""
    lean = np.array([-torque[0] - torque[1], torque[0] + torque[1],
                     torque[0] - torque[1], -torque[0] + torque[1]]) * np.sqrt(0.5)  # fmt: skip
    span = lean.max() - lean.min()
    if span > 1:
        lean /= span
    collective = min(collective, 1 - lean.max())
    if collective + lean.min() < 0:
        lean *= max(collective, 0.0) / -lean.min()
    room = 1.0
    for i in range(4):
        share = collective + lean[i]
        room = min(room, share, 1 - share)
    yaw = min(max(torque[2], -max(room, 0.0)), max(room, 0.0))
    for i in range(4):
        share = collective + lean[i] + (-yaw if i < 2 else yaw)
        speed = airframe[SPEED_MAX] * np.sqrt(min(max(share, 0.0), 1.0))
        speeds[i] = max(speed, airframe[SPEED_IDLE])


@njit(cache=True, nogil=True)
def believe(state, error, position, velocity, attitude):
    """The estimate: truth plus `error`."""
    for i in range(3):
        position[i] = state[i] + error[i]
        velocity[i] = state[3 + i] + error[3 + i]
    turn = np.array([1.0, 0.5 * error[6], 0.5 * error[7], 0.5 * error[8]])
    _product(turn, state[6:10], attitude)
    attitude /= np.sqrt((attitude**2).sum())


@njit(cache=True, nogil=True)
def fly(state, error, setpoint, limits, gains, motors, around, load, airframe, dt, steps, memory):
    """Advance the vehicle under control by `steps` of `dt`, in place.

    The position loop runs once, at the start; attitude, rates and rotors run at every step.
    Returns the mean sum of cubed rotor speeds, to which power is proportional.
    """
    position, velocity, attitude = np.empty(3), np.empty(3), np.empty(4)
    rates, torque, speeds = np.empty(3), np.empty(3), np.zeros(4)
    work = np.empty((5, 17))
    believe(state, error, position, velocity, attitude)
    tick = dt * steps
    blend = tick / (tick + 1 / (2 * np.pi * gains[CUT_VELOCITY]))
    for i in range(3):
        memory[15 + i] += blend * ((velocity[i] - memory[12 + i]) / tick - memory[15 + i])
        memory[12 + i] = velocity[i]
    if motors == FLYING:
        w, x, y, z = attitude
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        control_position(position, velocity, yaw, setpoint, limits, gains, tick, memory)
    else:
        memory[0:6] = 0.0
        memory[22] = 0.0
        if motors == IDLE:
            speeds[:] = airframe[SPEED_IDLE]
    cubes = 0.0
    for _ in range(steps):
        if motors == FLYING:
            believe(state, error, position, velocity, attitude)
            control_attitude(attitude, gains, memory, rates)
            control_rate(state[10:13], rates, gains, dt, memory, torque)
            mix(memory[22], torque, airframe, speeds)
        rk4(state, speeds, around, load, airframe, dt, work)
        for i in range(4):
            cubes += state[13 + i] ** 3
    return cubes / steps
