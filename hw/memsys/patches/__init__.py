"""From cells to the vertices of their patches: tables, filters, and the store with its I-structure."""
