"""The vehicle as the commander has it: body, wind, rotors' battery, control loops and estimate."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.world import World
from orchard_cli.simulator.body import Airframe, Body, Gusts
from orchard_cli.simulator.control import Cascade, Demand, Motors

from .battery import Battery, Pack
from .estimator import Estimator
from .parameters import Parameters
from .seen import Seen

TICK = 0.01  # s: the position loop and everything above it; PX4's runs at 100 Hz too


class Craft:
    """Flies demands, tick by tick. The same world and demands give the same bits."""

    def __init__(
        self,
        world: World,
        start_site: tuple[float, float],
        start_yaw_site: float,
        *,
        ground: tuple[float, float, float],
        airframe: Airframe,
        pack: Pack,
        values: Parameters,
        level: float = 0.0,
    ) -> None:
        wind_seed, noise_seed = np.random.SeedSequence([world.seed, 0x5157]).spawn(2)
        self.body = Body(airframe, start_site, start_yaw_site, ground, level)
        self.pumping = False
        self.battery = Battery(pack, airframe)
        self._before = self.body.velocity_site  # a tick ago
        self._values = values
        self._cascade = Cascade(values, TICK)
        self._tuned = values.version
        self._gusts = Gusts(world.wind, TICK, np.random.default_rng(wind_seed))
        self._estimator = Estimator(world.noise, TICK, np.random.default_rng(noise_seed))
        self._ticks = 0
        self.seen: Seen = self._estimator.look(self.body, self.time)

    @property
    def time(self) -> float:
        """s since boot."""
        return self._ticks * TICK

    @property
    def collective(self) -> float:
        """Thrust asked for last, share of the greatest."""
        return self._cascade.collective

    @property
    def attitude_wanted(self) -> Vector:
        """(4,) site_from_body asked for last."""
        return self._cascade.attitude_wanted

    @property
    def acceleration_site(self) -> Vector:
        """(3,) m/s², true, over the last tick."""
        change: Vector = self.body.velocity_site - self._before
        return change / TICK

    @property
    def battery_voltage(self) -> float:
        """V at the terminals."""
        v = self._values
        return self.battery.voltage(v["BAT1_N_CELLS"], v["BAT1_V_EMPTY"], v["BAT1_V_CHARGED"])

    def forget(self) -> None:
        """Zero the control integrals, as PX4 does on the ground."""
        self._cascade.forget()

    def jump_estimate(self, moved_site: Vector, turned: float = 0.0) -> None:
        """Reset the estimate: it is off by so much more, m and rad of heading, from now on."""
        self._estimator.jump(moved_site, turned)

    def set_wind(self, velocity_site: Vector) -> None:
        """Change the mean wind, m/s, from now on."""
        self._gusts.blow(velocity_site)

    def fly(self, demand: Demand, motors: Motors) -> None:
        """Fly one TICK, drain the battery, and look where that led."""
        if self._tuned != self._values.version:
            self._cascade.retune(self._values)
            self._tuned = self._values.version
        self._gusts.step(self.body.around)
        self._before = self.body.velocity_site
        cubes = self._cascade.fly(self.body, self._estimator.error, demand, motors)
        self.battery.drain(cubes, TICK)
        if self.pumping:
            self.body.pump(TICK)
        self._ticks += 1
        self.seen = self._estimator.look(self.body, self.time)
