"""The bus between clusters and main memory, and its caches."""
