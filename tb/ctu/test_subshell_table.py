import random

from hw.ctu.subshell_table import SubshellTable
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic, Rigid


class TestSubshellTable(Bench):
    component, changes, variants = SubshellTable, {"ctu.subshell_bits": 6}, ({},)

    def vectors(self, config):
        """Each entry is written twice, the last time with what is read."""
        draw, count = random.Random(2), config.ctu.subshells
        entries = [{"patch": draw.getrandbits(32), "shell": draw.getrandbits(32)} for _ in range(2 * count)]
        addresses = [*range(count), *(draw.randrange(count) for _ in range(200))]
        return Vectors(
            first={"i_load": [{"address": number % count, **entry} for number, entry in enumerate(entries)]},
            inputs={"i": addresses}, expected={"o": [entries[count + address] for address in addresses]})

    def stages(self, component, config):
        """A skid buffer without a register follows."""
        return [Rigid(component.latency), Elastic(0, 1)]
