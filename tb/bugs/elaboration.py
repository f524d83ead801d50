"""``python -m tb.bugs.elaboration PRESET``: every component can be elaborated in a preset's configuration."""

import sys

from golden.engine.config import PRESETS
from tb.docs.contents import makers
from tb.docs.structure import structures

if __name__ == "__main__":
    structures(makers(PRESETS[sys.argv[1]]))
