"""``python -m hw``."""

from hw.cli import main

main()
