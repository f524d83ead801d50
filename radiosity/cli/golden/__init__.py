"""Commands of ``python -m golden``, one module each; `radiosity.cli.golden.main` registers them."""
