"""Yosys as a program, as far as SymbiYosys uses it: ``yosys.py -ql LOG SCRIPT``.

The packaged program takes half a minute to start for the first time on a machine; the packaged library does not.
"""

import os
import sys

from pyosys import libyosys


def main() -> None:
    """Run the script; everything that is said goes to the log."""
    _, log, script = sys.argv[1:]
    os.dup2(os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)
    libyosys.run_pass(f"script {script}", libyosys.Design())


if __name__ == "__main__":
    main()
