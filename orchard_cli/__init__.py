"""orchard: plan, fly and analyze spray missions over orchards."""

__version__ = "0.1.0"
