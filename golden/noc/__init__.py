"""The network between clusters."""
