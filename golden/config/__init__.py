"""The one configuration of the golden model, the machine and its testbench.

Every parameter is a field of a frozen dataclass, one dataclass per unit; what follows from the parameters is a
property. Formats are those of `golden.fixed`. Parameters that say "Hardware only" change the machine's size and speed:
no hit depends on them, and only the plans of the host (`golden.schedule`, `golden.jobs`) read them.
"""

from golden.config.config import Config
from golden.config.ctu import Ctu
from golden.config.icu import Icu
from golden.config.memory import Memory
from golden.config.memsys import Memsys
from golden.config.noc import Noc
from golden.config.numbers import Numbers
from golden.config.presets import PRESETS

__all__ = ["PRESETS", "Config", "Ctu", "Icu", "Memory", "Memsys", "Noc", "Numbers"]
