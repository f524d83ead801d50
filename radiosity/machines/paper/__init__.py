"""The machine of Shen and Deprettere's paper: a host forms clusters for each step and pushes patches to them."""
