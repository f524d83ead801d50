"""Commands of ``python -m hw``, one module each; `hw.cli` registers them."""
