"""``python -m tb``: names the command that has replaced it."""

import sys

sys.stderr.write("error: python -m tb has become `radiosity COMMAND --method machine` (render, formfactors, cast)\n")
sys.exit(2)
