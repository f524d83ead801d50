"""``python -m golden``: the command line of the golden model."""

from golden.cli import main

main()
