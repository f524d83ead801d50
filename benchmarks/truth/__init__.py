"""References for hits that share nothing with the code under test: no module here imports golden or the hardware."""
