"""Bugs by hand, injected one at a time to measure the tests."""
