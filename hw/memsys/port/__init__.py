"""The port of main memory: bursts of AXI4, engines for outstanding requests, windows and time-outs."""
