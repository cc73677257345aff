"""orchard: plan, fly and analyze spray missions over orchards."""

from orchard_cli import kernel_cache

__version__ = "0.1.0"

kernel_cache.settle(__version__)  # before anything imports numba, which reads it once
