"""What `orchard doctor` looks at, one file a subject. Each gives its findings as values."""
