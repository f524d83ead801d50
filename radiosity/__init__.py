"""The command ``radiosity``: composes the golden model, the hardware and the simulated machine. Nothing imports it."""
