"""Charts as SVG, by matplotlib (extra ``plots``)."""
