"""The one configuration of the golden model, the machine and its testbench.

Every parameter is a field of a frozen dataclass, one dataclass per unit; what follows from the parameters is a
property. Formats are those of `golden.engine.lib.fixed`. Parameters that say "Hardware only" change the machine's size
and speed: no hit depends on them, and only the plans of the host (`golden.engine.schedule`, `golden.engine.jobs`) read
them.
"""

from golden.engine.config.config import Config
from golden.engine.config.ctu import Ctu
from golden.engine.config.icu import Icu
from golden.engine.config.memory import Memory
from golden.engine.config.memsys import Memsys
from golden.engine.config.noc import Noc
from golden.engine.config.numbers import Numbers
from golden.engine.config.presets import PRESETS

__all__ = ["PRESETS", "Config", "Ctu", "Icu", "Memory", "Memsys", "Noc", "Numbers"]
