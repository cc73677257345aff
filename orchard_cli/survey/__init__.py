"""Survey files -> Orchard and the crew's wishes."""

from .given import Given
from .load import Form, Survey, load, parse
from .on_terrain import on_terrain
from .tasks import load_tasks
from .writing import save, text_of

__all__ = [
    "Form",
    "Given",
    "Survey",
    "load",
    "load_tasks",
    "on_terrain",
    "parse",
    "save",
    "text_of",
]
