"""The host's scheduler: a sparse casting from one point predicts the work of dense castings from nearby points."""
