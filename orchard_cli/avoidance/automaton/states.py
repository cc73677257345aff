"""The automaton of Ahmed 2022: eleven states, Table 1, eqs. 23-26. Pure.

The text that we have lost its minus and not-equal signs. Restored here, and from what:

- q3 and q4: "S1 touched && d_b >= ..." is "S1 not touched": §2.2.1 says "the sensor S1 is not
  touched, and the value of d_b is bigger". In q4, the mirror of q3, d_b <= -l_DA sin(alpha).
- q4 and q9: the y-velocity is -v_A: q4 "starts flying in the y-axis direction negatively", and q9
  flies left like q4.
- q5: the table sends v_A < 0 to q6 and v_A > 0 to q7; the text has it the other way round, and only
  so do the sensors of q6 and q7 look at the obstacle: who flies right has it on the left, at S2.
- q2: with both lasers at their maximum "d3 >= d1" would always be true and q4 could never follow,
  so the side is by d_b then, as the text says, and by the lasers otherwise.
- The counted time is that of flying sideways, in q3 or q4 and on through q5.

The paper's y is + to the right; velocities here are (forward, right).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum


class State(Enum):
    """What the automaton does."""

    Q0 = "follow the reference"
    Q1 = "slow to the avoidance velocity"
    Q2 = "decide the side"
    Q3 = "fly right"
    Q4 = "fly left"
    Q5 = "fly on sideways"
    Q6 = "fly forward, obstacle on the left"
    Q7 = "fly forward, obstacle on the right"
    Q8 = "fly on forward"
    Q9 = "fly back left"
    Q10 = "fly back right"


S1, S2, S3, S4 = range(4)
NOTHING = math.inf
"""What a laser measures when nothing is within its reach: its maximum."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What the sensors say."""

    ahead: float  # m, d_0 of the radar; inf: nothing
    aside: float  # m, d_b = d_0 sin(phi), + when the obstacle is on the left; NaN: out of its sight
    lasers: tuple[float, float, float, float]  # m, d_1 to d_4; NOTHING: nothing


@dataclass(frozen=True, slots=True)
class Numbers:
    """What the load and the speed make of the manoeuvre."""

    slowdown: float  # m, d_SD
    first_safe: float  # m, d_S1
    speed: float  # m/s, v_A
    trigger: float  # s, t_TR
    corner: float  # m, l_DA sin(alpha)


@dataclass(frozen=True, slots=True)
class Memory:
    """Where the automaton is."""

    state: State = State.Q0
    since: float = 0.0  # s, when the state began
    now: float = 0.0  # s, of the last step
    counted: float = 0.0  # s flown sideways and not yet back
    rightwards: bool = False
    nearest: tuple[float, float, float, float] = (NOTHING,) * 4  # m, of each laser since q1

    def touched(self, laser: int) -> bool:
        """Whether a laser has met the obstacle."""
        return self.nearest[laser] < NOTHING


def advance(memory: Memory, reading: Reading, numbers: Numbers, now: float) -> Memory:
    """One look at the sensors. Deciding the side takes no time."""
    after = step(memory, reading, numbers, now)
    return step(after, reading, numbers, now) if after.state is State.Q2 else after


def step(memory: Memory, reading: Reading, numbers: Numbers, now: float) -> Memory:
    """One row of Table 1: the next state, or the same one later."""
    memory = _counted(memory, reading, now)
    to = _next(memory, reading, numbers)
    if to is memory.state:
        return memory
    if to is State.Q1:
        return Memory(to, now, now, nearest=reading.lasers)
    rightwards = to is State.Q3 if to in (State.Q3, State.Q4) else memory.rightwards
    nearest = memory.nearest
    if to in (State.Q6, State.Q7):  # what stood beside the row before is another thing
        nearest = (nearest[S1], NOTHING, nearest[S3], NOTHING)
    return replace(memory, state=to, since=now, rightwards=rightwards, nearest=nearest)


def _counted(memory: Memory, reading: Reading, now: float) -> Memory:
    """The time that passed, and the lasers' least ranges."""
    passed, state = now - memory.now, memory.state
    counted = memory.counted
    if state in (State.Q3, State.Q4, State.Q5):
        counted += passed
    elif state in (State.Q9, State.Q10):
        counted -= passed
    a, b = memory.nearest, reading.lasers
    nearest = (min(a[0], b[0]), min(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3]))
    return replace(memory, now=now, counted=counted, nearest=nearest)


def _next(memory: Memory, reading: Reading, numbers: Numbers) -> State:
    state, d = memory.state, reading.lasers
    triggered = memory.now - memory.since >= numbers.trigger
    aside = 0.0 if math.isnan(reading.aside) else reading.aside
    gone = math.isnan(reading.aside)
    leaves: dict[State, tuple[bool, State]] = {
        State.Q0: (reading.ahead <= numbers.slowdown + numbers.first_safe, State.Q1),
        State.Q1: (reading.ahead <= numbers.first_safe, State.Q2),
        State.Q2: (True, _side(aside, d[S1], d[S3])),
        State.Q3: (
            (not memory.touched(S1) and (gone or aside >= numbers.corner))
            or (memory.touched(S1) and d[S1] == NOTHING),
            State.Q5,
        ),
        State.Q4: (
            (not memory.touched(S3) and (gone or aside <= -numbers.corner))
            or (memory.touched(S3) and d[S3] == NOTHING),
            State.Q5,
        ),
        State.Q5: (triggered, State.Q6 if memory.rightwards else State.Q7),
        State.Q6: (memory.touched(S2) and d[S2] == NOTHING, State.Q8),
        State.Q7: (memory.touched(S4) and d[S4] == NOTHING, State.Q8),
        State.Q8: (triggered, State.Q9 if memory.nearest[S2] < memory.nearest[S4] else State.Q10),
        State.Q9: (memory.counted <= 0.0, State.Q0),
        State.Q10: (memory.counted <= 0.0, State.Q0),
    }
    leaving, to = leaves[state]
    return to if leaving else state


def _side(aside: float, left: float, right: float) -> State:
    """Away from where the obstacle is; straight ahead, to the right."""
    if left == NOTHING and right == NOTHING:
        return State.Q3 if aside >= 0 else State.Q4
    return State.Q3 if right >= left else State.Q4


def velocity(memory: Memory, numbers: Numbers) -> tuple[float, float]:
    """m/s (forward, right) that a state flies; q0 follows the reference and has none."""
    v = numbers.speed
    sideways = v if memory.rightwards else -v
    flown = {
        State.Q1: (v, 0.0),
        State.Q3: (0.0, v),
        State.Q4: (0.0, -v),
        State.Q5: (0.0, sideways),
        State.Q6: (v, 0.0),
        State.Q7: (v, 0.0),
        State.Q8: (v, 0.0),
        State.Q9: (0.0, -v),
        State.Q10: (0.0, v),
    }
    return flown[memory.state]
