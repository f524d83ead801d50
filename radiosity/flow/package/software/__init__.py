"""What a host of an exported engine needs: a driver in C99, and a simulation that uses it."""
