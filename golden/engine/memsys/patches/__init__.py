"""From cells to patches: tables, filter, and the store with its I-structure."""
