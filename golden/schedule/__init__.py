"""The host's scheduler: what a sparse casting from one point tells about dense ones from points nearby."""
