"""``python -m radiosity``."""

from radiosity.cli.main import main

main(prog_name="radiosity")
