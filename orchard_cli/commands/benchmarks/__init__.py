"""What `orchard bench` measures: one file per kind of work, none of it in the flight's way."""
