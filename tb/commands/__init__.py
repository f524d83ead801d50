"""Commands of ``python -m tb``, one module each; `tb.cli` registers them."""
