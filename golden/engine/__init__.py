"""The machine in integers, block for block as in `hw`: numpy alone, without a compiler."""
