"""The memory unit of a cluster: what is written once and waited for, what has been asked for already."""
