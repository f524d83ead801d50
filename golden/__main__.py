"""``python -m golden``: the command line of the golden model."""

from radiosity.cli.golden.main import main

main()
