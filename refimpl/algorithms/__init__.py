"""The algorithms of the pair table, one file per family."""
