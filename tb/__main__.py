"""``python -m tb``: the command line of the simulated machine."""

from tb.cli import main

main()
