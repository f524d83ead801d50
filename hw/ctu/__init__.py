"""The cell traversal unit: grid rays open the cells of one shell after the other."""
