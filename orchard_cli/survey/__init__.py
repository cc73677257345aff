"""Survey files -> Orchard and the crew's wishes."""

from .given import Given
from .load import Form, Survey, load, parse
from .tasks import load_tasks
from .writing import save, text_of

__all__ = ["Form", "Given", "Survey", "load", "load_tasks", "parse", "save", "text_of"]
