"""The memory system: patch lists of cells, filters and the I-structure of a cluster, and the caches behind the bus."""
