"""Log -> metrics, comparison, pictures."""
