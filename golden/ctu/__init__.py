"""The cell-traversal unit: sparse grid rays that open the cells of one shell after the other."""
