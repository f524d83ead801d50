"""The registers of the machine, and their table."""
