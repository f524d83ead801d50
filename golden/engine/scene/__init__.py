"""A scene in the machine's integers: its coordinates and its patches."""
