"""The memory system of a cluster: patch lists of cells, filters, caches and the I-structure."""
