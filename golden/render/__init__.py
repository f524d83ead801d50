"""Pictures: two passes of light, cast in double precision or in the machine's integers."""
