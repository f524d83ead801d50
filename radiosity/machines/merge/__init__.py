"""Machine F: pictures by nodes with memories of their own, merged pixel by pixel or split by regions, simulated."""
