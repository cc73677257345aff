"""Random orchards to fly in, and what became of a flight, judged by the truth. Flies nothing."""

from .case import Case, make_case
from .judge import Judgement, Outcome, judge
from .witness import Witness
from .world_text import world_text

__all__ = ["Case", "Judgement", "Outcome", "Witness", "judge", "make_case", "world_text"]
