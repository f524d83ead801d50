"""The engine with any number of clusters, simulated."""
