"""Commands of ``python -m golden``, one module each; `golden.cli` registers them."""
