"""Command lines: what only ``radiosity`` has, and in folders what ``python -m golden`` and ``python -m hw`` have."""
