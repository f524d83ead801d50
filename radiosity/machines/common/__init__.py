"""What simulators of several machines share: events, the hypercube and its messages, hashes."""
