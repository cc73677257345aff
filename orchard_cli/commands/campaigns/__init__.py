"""What `orchard campaign` does."""
