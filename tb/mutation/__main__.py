"""``python -m tb.mutation``: the mutation score of the testbenches.

Yosys makes mutants of each block, with a connection constant, inverted or swapped, and the block's testbench runs on
each. A large block's parts have mutants and testbenches of their own.
"""

from tb.mutation.score import main

if __name__ == "__main__":
    main()
