"""The memory unit of a cluster: which patches are in a cell, and what has been asked for already."""
