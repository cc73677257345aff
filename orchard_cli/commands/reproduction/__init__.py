"""One file per paper: its tables, measured anew. registry.py lists them."""
