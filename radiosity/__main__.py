"""``python -m radiosity``."""

from radiosity.cli import main

main(prog_name="radiosity")
