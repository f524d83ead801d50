"""The memory system of a cluster, its caches, and the port of main memory."""
