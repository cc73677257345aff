"""Survey files -> Orchard and the crew's wishes."""

from .given import Given
from .load import Form, Survey, load, parse
from .writing import save, text_of

__all__ = ["Form", "Given", "Survey", "load", "parse", "save", "text_of"]
