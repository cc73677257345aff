"""The inflated map: lookups along legs and curves."""
