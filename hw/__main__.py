"""``python -m hw``."""

from radiosity.cli.hw.main import main

main()
