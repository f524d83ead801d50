"""Testbenches of the memory system, and the models of memory and network around it."""
