from hw.control.near_cell_banks import NearCellBanks
from tb.lib.bench import Bench
from tb.lib.registers import Registers


class TestNearCellBanks(Bench):
    """Cells of one bank are sent for every section, while the other one is loaded."""

    component, changes, variants, span = NearCellBanks, {"ctu.near_cell_bits": 5}, ({},), 300

    def model(self, config):
        """A cell at a time enters the pipeline."""
        count, width = 1 << config.ctu.near_cell_bits, 24
        cells, self.sent, steps, pipe = [[None] * count for _ in range(2)], None, [], Registers(2)
        given = yield
        while True:
            outputs = {"i": not steps, "o": pipe[0]}
            moves = pipe.moves(given.o)
            if steps and moves:
                address, is_cell, last = steps.pop(0)
                pipe.step({"cell": cells[self.sent][address] if is_cell else None, "is_cell": is_cell, "last": last},
                          given.o)
            elif steps or given.i is None:
                pipe.step(None, given.o)
            else:
                pipe.step(None, given.o)
                self.sent, most = given.i["bank"], max(1, given.i["count"])
                steps = [(k, given.i["count"] > 0, k == most - 1) for k in range(most)]
            if given.i_load is not None:
                address, both = 2 * given.i_load["address"], given.i_load["cells"]
                cells[given.i_load["bank"]][address:address + 2] = both & (1 << width) - 1, both >> width
            given = yield outputs

    def drive(self, given, random):
        """No load of the bank that is being sent, nor that will be while it is loaded; all counts."""
        if given.i is not None:
            given.i["count"] = min(given.i["count"], 1 << self.config().ctu.near_cell_bits)
        if given.i_load is not None:
            busy = self.sent if given.i is None else given.i["bank"]
            given.i_load["bank"] = given.i_load["bank"] if busy is None else 1 - busy
