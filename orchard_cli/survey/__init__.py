"""Survey files -> Orchard."""
