"""The simulated autopilot: PX4's rules without its input and output."""

from .autopilot import Autopilot
from .craft import TICK
from .modes import Mode, Result
from .plan import Does, Item
from .steered import Sticks, Wanted

__all__ = ["TICK", "Autopilot", "Does", "Item", "Mode", "Result", "Sticks", "Wanted"]
