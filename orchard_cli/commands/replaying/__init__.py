"""What `orchard replay` does with a log."""
