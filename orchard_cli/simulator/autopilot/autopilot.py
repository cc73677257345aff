"""The simulated PX4: arming, modes, failsafes, and the vehicle that it flies. No input or output.

Time is counted from boot in ticks of TICK; the same seed and the same calls give the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.vehicle import Landed
from orchard_cli.model.world import World
from orchard_cli.simulator.body import X500, Airframe
from orchard_cli.simulator.control import FREE, Demand, Motors

from .battery import Pack
from .craft import TICK, Craft
from .failsafe import Threats, failsafe
from .following import Follow
from .ground import AutoDisarm, LandDetector, Lift, Takeoff
from .inputs import Inputs
from .modes import Mode, Result
from .parameters import Parameters
from .plan import Item
from .returning import Return
from .seen import Seen
from .steered import Sticks, Wanted, position_mode
from .tasks import Hold, Land, TakeOff, Task, demand_of

BOOT = 2.0  # s until the arming checks can pass


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
        level: float = 0.0,
    ) -> None:
        self.parameters = Parameters(parameters)
        self.craft = Craft(
            world, start_site, start_yaw_site, ground=ground, airframe=airframe,
            pack=pack or Pack(), values=self.parameters, level=level,
        )  # fmt: skip
        self.inputs = Inputs(self.parameters)
        self.armed = False
        self.intention = self.mode = Mode.HOLD
        self.home_site: Vector = self.seen.position_site
        self.mission: tuple[Item, ...] = ()
        self.mission_index = 0
        self.reached: list[int] = []  # mission items reached and not yet told
        self.detector = LandDetector()
        self.takeoff = Takeoff()
        self._auto_disarm = AutoDisarm()
        self._rest_mode = Mode.HOLD  # the mode after disarming
        self._takeoff_height = math.nan
        self._task: Task = Hold(self.seen, self.parameters)
        self.demand: Demand = self._task.demand(self.parameters)

    # -- what it says

    @property
    def time(self) -> float:
        """s since boot."""
        return self.craft.time

    @property
    def seen(self) -> Seen:
        """The present estimate."""
        return self.craft.seen

    @property
    def landed(self) -> Landed:
        """PX4's landed state, as EXTENDED_SYS_STATE tells it."""
        if self.detector.landed:
            return Landed.ON_GROUND
        rising = isinstance(self._task, Follow) and self._task.rising
        if self.mode is Mode.TAKEOFF or (self.mode is Mode.MISSION and rising):
            return Landed.TAKING_OFF
        return Landed.LANDING if self._task.lands else Landed.IN_AIR

    @property
    def global_position_ok(self) -> bool:
        """Whether there is a settled GPS fix."""
        return self.inputs.position_ok(self.time)

    def not_ready(self) -> tuple[str, ...]:
        """Why it would refuse to arm now, in words; empty when it would not."""
        mode, now = self.intention, self.time
        low = self.craft.battery.share <= self.parameters["BAT_CRIT_THR"]
        reasons = (
            ("GPS fix too low", not self.global_position_ok),
            ("system starting", now < BOOT),
            ("battery unhealthy", low),
            (f"mode {mode.name.lower()} prevents arming", not mode.arms),
            ("no offboard signal", mode is Mode.OFFBOARD and not self.inputs.setpoints_alive(now)),
            ("no manual control", mode is Mode.POSCTL and not self.inputs.pilot_alive(now)),
            ("no mission", mode is Mode.MISSION and not self.mission),
        )
        return tuple(words for words, fails in reasons if fails)

    @property
    def mission_complete(self) -> bool:
        """Whether the last item of a mission is done."""
        return bool(self.mission) and self.mission_index >= len(self.mission)

    @property
    def target_site(self) -> Vector:
        """(3,) m, where the present automatic mode heads for."""
        return self._task.target

    # -- what it is told

    def set_gps_fix(self, fix: bool) -> None:
        """Take or give the GPS fix."""
        self.inputs.set_gps_fix(fix, self.time)

    def arm(self, force: bool = False) -> Result:
        """Arm when every check passes, or by force."""
        if self.armed:
            return Result.ACCEPTED
        if self.not_ready() and not force:
            return Result.TEMPORARILY_REJECTED
        self.armed = True
        self._auto_disarm.armed(self.time)
        self.home_site = self.seen.position_site
        self._enter(self.intention)
        return Result.ACCEPTED

    def disarm(self, force: bool = False) -> Result:
        """Disarm on the ground; by force anywhere, which in the air is a fall."""
        if self.armed and not (self.detector.landed or force):
            return Result.TEMPORARILY_REJECTED
        if self.armed:
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
        self.inputs.wanted = wanted

    def pilot(self, sticks: Sticks) -> None:
        """Take the pilot's sticks into account."""
        self.inputs.sticks = sticks

    def upload(self, mission: tuple[Item, ...]) -> None:
        """Replace the mission."""
        self.mission = mission
        self.jump(0)

    def jump(self, index: int) -> None:
        """Go on with mission item `index`."""
        self.mission_index = index
        if self.mode is Mode.MISSION:
            self._enter(self.mode)

    # -- what it does

    def step(self) -> None:
        """Fly one TICK."""
        self._choose_mode()
        self._lift_and_land()
        self.demand = self._ask()
        self.craft.fly(self.demand, self._motors())

    def _can_fly(self, mode: Mode) -> bool:
        if mode is Mode.OFFBOARD:
            return self.inputs.setpoints_alive(self.time)
        if mode is Mode.POSCTL:
            return self.inputs.pilot_alive(self.time)
        if mode is Mode.LAND:
            return (
                True  # PX4 asks for a local position alone, and without one descends all the same
            )
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
            pilot = self.inputs.pilot_alive(self.time)
            alive = self.inputs.setpoints_alive(self.time)
            threats = Threats(
                setpoints_lost=mode is Mode.OFFBOARD and not alive,
                pilot_lost=mode is Mode.POSCTL and not pilot,
                pilot_there=pilot,
                battery=self.craft.battery.share,
            )
            mode = failsafe(mode, threats, self.parameters)
        if mode is not self.mode:
            self._enter(mode)

    def _lift_and_land(self) -> None:
        """Take-off ramp, land detector, and the rules of disarming."""
        values, now = self.parameters, self.time
        self.detector.step(self.seen, self.armed, self.craft.collective, self._sinks(), values)
        landed = self.detector.landed
        self.takeoff.step(now, TICK, self.armed, landed, self._climbs(), values)
        if self.armed and self._auto_disarm.due(now, landed, values):
            self.disarm()

    def _climbs(self) -> bool:
        """Whether the mode asks to leave the ground."""
        if self.mode is Mode.OFFBOARD:
            return self.inputs.wanted is not None and self.inputs.wanted.climbs(self.seen)
        if self.mode is Mode.POSCTL:
            return self.inputs.sticks is not None and self.inputs.sticks.up > 0.1
        return self._task.climbs

    def _sinks(self) -> bool:
        """Whether the mode asks to go down."""
        if self.mode in (Mode.OFFBOARD, Mode.POSCTL):
            return bool(self.demand.velocity_site[2] < -0.2)
        return self._task.sinks

    def _ask(self) -> Demand:
        """What the controller is asked for in this tick."""
        lift, values = self.takeoff.lift, self.parameters
        if lift in (Lift.DISARMED, Lift.SPOOLUP, Lift.READY):
            return self._rest(0.0)
        if lift is Lift.FLIGHT and self.detector.contact:
            return self._rest(values["MPC_THR_MIN"])
        if self.mode is Mode.OFFBOARD and self.inputs.wanted is not None:
            demand = self.inputs.wanted.demand(values)
        elif self.mode is Mode.POSCTL and self.inputs.sticks is not None:
            demand = self._piloted(self.inputs.sticks)
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
        if sticks.forward or sticks.left or sticks.up:
            self._task = Hold(self.seen, self.parameters)
        return position_mode(sticks, self._task.target, self.seen, self.parameters)

    def _rest(self, collective: float) -> Demand:
        """On the ground: no corrections, no wind-up, least thrust."""
        self.craft.forget()
        down = np.array([0.0, 0.0, -100.0])
        rest = demand_of(FREE, FREE, down, self.seen.yaw_site, 0.0, self.parameters)
        return rest.pressed(collective)

    def _motors(self) -> Motors:
        if not self.armed:
            return Motors.OFF
        flying = self.takeoff.lift in (Lift.RAMPUP, Lift.FLIGHT)
        return Motors.FLYING if flying else Motors.IDLE
