"""How the occupancy grid weighs evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass

RESOLUTION = 2000
"""Log-odds are kept as int16 in steps of 1/2000: fine enough to fade slowly, a quarter of the
memory traffic of doubles."""


@dataclass(frozen=True, slots=True)
class GridSettings:
    """Sizes and probabilities; every one is checked at construction (ValueError names all faults).

    With the defaults an unknown cell is occupied after two frames that hit it, one that was seen
    free after three; a ghost seen once is never occupied.
    """

    cell: float = 0.1  # m (Liu 2024, §3)
    size: tuple[int, int, int] = (256, 256, 64)  # cells along x, y, z, powers of two
    p_hit: float = 0.70  # of a cell with returns in it
    p_miss: float = 0.40  # of a cell that is seen through
    p_free: float = 0.25  # no cell becomes more certainly free than this
    p_certain: float = 0.97  # no cell becomes more certainly occupied than this
    p_occupied: float = 0.80  # a cell at least this probable is an obstacle
    half_life: float = 30.0  # s in which unseen evidence loses half its log-odds
    min_returns: int = 2  # a cell with fewer returns in a frame has none: single-pixel ghosts
    roll_slack: float = 0.8  # m the vehicle may leave the grid's centre before the grid rolls

    def __post_init__(self) -> None:
        probabilities = (
            0 < self.p_free <= self.p_miss < 0.5 < self.p_hit <= self.p_certain <= 0.999
            and 0.5 < self.p_occupied <= self.p_certain
        )
        checks = (
            (0.01 <= self.cell <= 1.0, "cell: 0.01 to 1 m"),
            (len(self.size) == 3 and all(_power_of_two(n) for n in self.size),
             "size: three powers of two from 8 to 1024"),
            (math.prod(self.size) <= 2**26, "size: more than 2^26 cells"),
            (probabilities, "p_*: free <= miss < 0.5 < hit <= certain, 0.5 < occupied <= certain"),
            (math.isfinite(self.half_life) and self.half_life > 0, "half_life: positive seconds"),
            (1 <= self.min_returns <= 255, "min_returns: 1 to 255"),
            (0 <= self.roll_slack <= self.cell * min(self.size) / 4, "roll_slack: within the grid"),
        )  # fmt: skip
        faults = [fault for good, fault in checks if not good]
        if faults:
            raise ValueError("; ".join(faults))


def _power_of_two(n: int) -> bool:
    return 8 <= n <= 1024 and n & (n - 1) == 0


def stored_log_odds(probability: float) -> int:
    """Log-odds of a probability in the grid's integer steps."""
    return round(RESOLUTION * math.log(probability / (1 - probability)))
