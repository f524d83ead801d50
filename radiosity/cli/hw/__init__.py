"""Commands of ``python -m hw``, one module each; `radiosity.cli.hw.main` registers them."""
