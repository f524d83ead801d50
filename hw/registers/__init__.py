"""The registers: what the host says to the machine and the machine to the host."""
