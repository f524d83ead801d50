"""Machine E: radiosity by gathering on a hypercube of nodes with memories of their own, simulated."""
