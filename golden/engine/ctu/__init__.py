"""The cell traversal unit (CTU): sparse grid rays open the cells of one shell after the other."""
