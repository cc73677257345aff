"""The simulated PX4: arming, modes, failsafes, and the vehicle that it flies. No input or output.

Time is counted from boot in ticks of TICK; the same seed and the same calls give the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.vehicle import Landed
from orchard_cli.model.world import World
from orchard_cli.simulator.body import X500, Airframe, Body, Gusts
from orchard_cli.simulator.control import FREE, Cascade, Demand, Motors

from .battery import Battery, Pack
from .estimator import Estimator
from .failsafe import Threats, failsafe
from .following import Follow
from .ground import LandDetector, Lift, Takeoff
from .modes import Mode, Result
from .parameters import Parameters
from .plan import Item
from .returning import Return
from .seen import Seen, see
from .steered import Sticks, Wanted, position_mode
from .tasks import Hold, Land, TakeOff, Task, demand_of

TICK = 0.01  # s
BOOT = 2.0  # s until the arming checks can pass
GPS_SETTLE = 2.9  # s from a fix to a global position (measured, px4/README §4)


class Autopilot:
    """One simulated vehicle with its autopilot, in the site frame."""

    def __init__(
        self,
        world: World,
        start_site: tuple[float, float],
        start_yaw_site: float,
        *,
        ground: tuple[float, float, float] = (0.0, 0.0, 0.0),
        airframe: Airframe = X500,
        pack: Pack | None = None,
        parameters: dict[str, float] | None = None,
    ) -> None:
        wind_seed, noise_seed = np.random.SeedSequence([world.seed, 0x5157]).spawn(2)
        self.time = 0.0
        self._ticks = 0
        self.parameters = Parameters(parameters)
        self.body = Body(airframe, start_site, start_yaw_site, ground)
        self.battery = Battery(pack or Pack(), airframe)
        self.armed = False
        self.intention = Mode.HOLD
        self.mode = Mode.HOLD
        self.mission: tuple[Item, ...] = ()
        self.mission_index = 0
        self.reached: list[int] = []  # mission items reached and not yet told
        self.acceleration_site = np.zeros(3)  # m/s², true, over the last tick
        self.gps_fix = True
        self._gps_since = -GPS_SETTLE
        self._rest_mode = Mode.HOLD
        self._cascade = Cascade(self.parameters, TICK)
        self._tuned = self.parameters.version
        self._gusts = Gusts(world.wind, TICK, np.random.default_rng(wind_seed))
        self._estimator = Estimator(world.noise, TICK, np.random.default_rng(noise_seed))
        self._error = self._estimator.step()
        self.seen: Seen = see(0.0, self.body.state, self._error, self.body.ground_height)
        self.home_site: Vector = self.seen.position_site
        self.detector = LandDetector()
        self.takeoff = Takeoff()
        self._task: Task = Hold(self.seen, self.parameters)
        self._takeoff_height = math.nan
        self.wanted: Wanted | None = None
        self._sticks: Sticks | None = None
        self._armed_at = self._landed_at = 0.0
        self._flew = False
        self.demand: Demand = self._task.demand(self.parameters)

    # -- what it says

    @property
    def landed(self) -> Landed:
        """PX4's landed state, as EXTENDED_SYS_STATE tells it."""
        if self.detector.landed:
            return Landed.ON_GROUND
        if self.mode is Mode.TAKEOFF or (self.mode is Mode.MISSION and self._rising):
            return Landed.TAKING_OFF
        return Landed.LANDING if self._task.lands else Landed.IN_AIR

    @property
    def _rising(self) -> bool:
        return isinstance(self._task, Follow) and self._task.rising

    @property
    def global_position_ok(self) -> bool:
        """Whether there is a settled GPS fix."""
        return self.gps_fix and self.time - self._gps_since >= GPS_SETTLE

    @property
    def setpoints_alive(self) -> bool:
        """Whether the offboard stream is younger than COM_OF_LOSS_T."""
        return self.wanted is not None and (
            self.time - self.wanted.time <= self.parameters["COM_OF_LOSS_T"]
        )

    @property
    def pilot_alive(self) -> bool:
        """Whether sticks came within COM_RC_LOSS_T."""
        return self._sticks is not None and (
            self.time - self._sticks.time <= self.parameters["COM_RC_LOSS_T"]
        )

    def not_ready(self) -> tuple[str, ...]:
        """Why it would refuse to arm now, in words; empty when it would not."""
        low = self.battery.share <= self.parameters["BAT_CRIT_THR"]
        mode = self.intention
        reasons = (
            ("GPS fix too low", not self.global_position_ok),
            ("system starting", self.time < BOOT),
            ("battery unhealthy", low),
            (f"mode {mode.name.lower()} prevents arming", not mode.arms),
            ("no offboard signal", mode is Mode.OFFBOARD and not self.setpoints_alive),
            ("no manual control", mode is Mode.POSCTL and not self.pilot_alive),
            ("no mission", mode is Mode.MISSION and not self.mission),
        )
        return tuple(words for words, fails in reasons if fails)

    @property
    def mission_complete(self) -> bool:
        """Whether the last item of a mission is done."""
        return bool(self.mission) and self.mission_index >= len(self.mission)

    @property
    def collective(self) -> float:
        """Thrust asked for last, share of the greatest."""
        return self._cascade.collective

    @property
    def battery_voltage(self) -> float:
        """V at the terminals."""
        v = self.parameters
        return self.battery.voltage(v["BAT1_N_CELLS"], v["BAT1_V_EMPTY"], v["BAT1_V_CHARGED"])

    @property
    def attitude_wanted(self) -> Vector:
        """(4,) site_from_body asked for last."""
        return self._cascade.attitude_wanted

    @property
    def target_site(self) -> Vector:
        """(3,) m, where the present automatic mode heads for."""
        return self._task.target

    # -- what it is told

    def set_gps_fix(self, fix: bool) -> None:
        """Take or give the GPS fix."""
        if fix and not self.gps_fix:
            self._gps_since = self.time
        self.gps_fix = fix

    def arm(self, force: bool = False) -> Result:
        """Arm when every check passes, or by force."""
        if self.armed:
            return Result.ACCEPTED
        if self.not_ready() and not force:
            return Result.TEMPORARILY_REJECTED
        self.armed = True
        self._armed_at = self.time
        self._flew = False
        self.home_site = self.seen.position_site
        self._enter(self.intention)
        return Result.ACCEPTED

    def disarm(self, force: bool = False) -> Result:
        """Disarm on the ground; by force anywhere, which in the air is a fall."""
        if self.armed and not (self.detector.landed or force):
            return Result.TEMPORARILY_REJECTED
        self.armed = False
        self.intention = self._rest_mode
        self._enter(self.intention)
        return Result.ACCEPTED

    def set_mode(self, mode: Mode) -> Result:
        """Ask for a mode. Disarmed, PX4 takes any; armed, only one that can be flown now."""
        if self.armed and not self._can_fly(mode):
            return Result.TEMPORARILY_REJECTED
        self.intention = mode
        if mode.arms:
            self._rest_mode = mode
        if mode is Mode.MISSION and self.mission_complete:
            self.mission_index = 0
        self._enter(mode)
        return Result.ACCEPTED

    def take_off(self, height_site: float = math.nan) -> Result:
        """Take off to a height (NaN: MIS_TAKEOFF_ALT above home); disarmed, once it is armed."""
        self._takeoff_height = height_site
        return self.set_mode(Mode.TAKEOFF)

    def offboard(self, wanted: Wanted) -> None:
        """Take an offboard setpoint into account; in other modes it only keeps the stream alive."""
        self.wanted = wanted

    def pilot(self, sticks: Sticks) -> None:
        """Take the pilot's sticks into account."""
        self._sticks = sticks

    def upload(self, mission: tuple[Item, ...]) -> None:
        """Replace the mission."""
        self.mission = mission
        self.mission_index = 0
        if self.mode is Mode.MISSION:
            self._enter(self.mode)

    def jump(self, index: int) -> None:
        """Go on with mission item `index`."""
        self.mission_index = index
        if self.mode is Mode.MISSION:
            self._enter(self.mode)

    # -- what it does

    def step(self) -> None:
        """Fly one TICK."""
        if self._tuned != self.parameters.version:
            self._cascade.retune(self.parameters)
            self._tuned = self.parameters.version
        self._choose_mode()
        self._lift_and_land()
        self.demand = self._ask()
        self.body.around[:3] = self._gusts.step()
        before = self.body.velocity_site
        cubes = self._cascade.fly(self.body, self._error, self.demand, self._motors())
        self.acceleration_site = (self.body.velocity_site - before) / TICK
        self.battery.drain(cubes, TICK)
        self._ticks += 1
        self.time = self._ticks * TICK
        self._error = self._estimator.step()
        self.seen = see(self.time, self.body.state, self._error, self.body.ground_height)

    def _can_fly(self, mode: Mode) -> bool:
        if mode is Mode.OFFBOARD:
            return self.setpoints_alive
        if mode is Mode.POSCTL:
            return self.pilot_alive
        return self.global_position_ok and (mode is not Mode.MISSION or bool(self.mission))

    def _enter(self, mode: Mode) -> None:
        """Begin a mode afresh."""
        self.mode = mode
        seen, values = self.seen, self.parameters
        if mode is Mode.TAKEOFF:
            height = self._takeoff_height
            if math.isnan(height):
                height = float(self.home_site[2]) + values["MIS_TAKEOFF_ALT"]
            self._task = TakeOff(seen, values, height)
        elif mode is Mode.LAND:
            self._task = Land(seen, values)
        elif mode is Mode.RETURN:
            self._task = Return(seen, values, self.home_site)
        elif mode is Mode.MISSION and self.mission:
            self._task = Follow(seen, values, self.mission, self.mission_index, self.home_site)
        else:
            self._task = Hold(seen, values)

    def _choose_mode(self) -> None:
        """The intention, unless a failsafe overrules it; and back when the threat is over."""
        if self.mode is Mode.TAKEOFF and self._task.done:
            self.intention = self._rest_mode = self.mode = Mode.HOLD
            self._task = Hold.after(self._task, self.seen, self.parameters)
        mode = self.intention
        if self.armed:
            threats = Threats(
                setpoints_lost=mode is Mode.OFFBOARD and not self.setpoints_alive,
                pilot_lost=mode is Mode.POSCTL and not self.pilot_alive,
                pilot_there=self.pilot_alive,
                battery=self.battery.share,
            )
            mode = failsafe(mode, threats, self.parameters)
        if mode is not self.mode:
            self._enter(mode)

    def _lift_and_land(self) -> None:
        """Take-off ramp, land detector, and the two rules of disarming."""
        values, now = self.parameters, self.time
        landed_before = self.detector.landed
        self.detector.step(
            self.seen, self.armed, self._cascade.collective, self._sinks(), values
        )
        self.takeoff.step(now, TICK, self.armed, self.detector.landed, self._climbs(), values)
        if not self.detector.landed:
            self._flew = True
        elif not landed_before:
            self._landed_at = now
        if self.armed and self.detector.landed:
            since, limit = (
                (self._landed_at, values["COM_DISARM_LAND"])
                if self._flew
                else (self._armed_at, values["COM_DISARM_PRFLT"])
            )
            if limit > 0 and now - since >= limit:
                self.disarm()

    def _climbs(self) -> bool:
        if self.mode is Mode.OFFBOARD:
            return self.wanted is not None and self.wanted.climbs(self.seen)
        if self.mode is Mode.POSCTL:
            return self._sticks is not None and self._sticks.up > 0.1
        return self._task.climbs

    def _sinks(self) -> bool:
        if self.mode in (Mode.OFFBOARD, Mode.POSCTL):
            return bool(self.demand.velocity_site[2] < -0.2)
        return self._task.sinks

    def _ask(self) -> Demand:
        """What the controller is asked for in this tick."""
        lift, values = self.takeoff.lift, self.parameters
        on_ground = lift in (Lift.DISARMED, Lift.SPOOLUP, Lift.READY)
        if on_ground or (lift is Lift.FLIGHT and self.detector.contact):
            return self._rest(values["MPC_THR_MIN"] if lift is Lift.FLIGHT else 0.0)
        if self.mode is Mode.OFFBOARD and self.wanted is not None:
            demand = self.wanted.demand(values)
        elif self.mode is Mode.POSCTL and self._sticks is not None:
            demand = self._piloted(self._sticks)
        else:
            demand = self._task.step(self.seen, values, TICK)
        if isinstance(self._task, Follow):
            self.mission_index = self._task.index
            self.reached += self._task.take_reached()
        if lift is Lift.RAMPUP:
            climb = self.takeoff.climb_limit(values["MPC_TKO_SPEED"], values)
            demand = demand.ramped(climb, math.radians(values["MPC_TILTMAX_LND"]))
        return demand

    def _piloted(self, sticks: Sticks) -> Demand:
        """Sticks to a demand; a stick that is let go holds where braking ends."""
        hold = self._task.target
        if sticks.forward or sticks.left or sticks.up:
            self._task = Hold(self.seen, self.parameters)
        return position_mode(sticks, hold, self.seen, self.parameters)

    def _rest(self, collective: float) -> Demand:
        """On the ground: no corrections, no wind-up, least thrust."""
        self._cascade.forget()
        down = np.array([0.0, 0.0, -100.0])
        rest = demand_of(FREE, FREE, down, self.seen.yaw_site, 0.0, self.parameters)
        return rest.pressed(collective)

    def _motors(self) -> Motors:
        if not self.armed:
            return Motors.OFF
        flying = self.takeoff.lift in (Lift.RAMPUP, Lift.FLIGHT)
        return Motors.FLYING if flying else Motors.IDLE
