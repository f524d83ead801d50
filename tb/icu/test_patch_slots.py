from hw.icu.icu_formats import IcuFormats
from hw.icu.patch_slots import PatchSlots
from tb.lib.bench import Bench
from tb.lib.shift_registers import ShiftRegisters


class TestPatchSlots(Bench):
    component, arguments, changes, variants = PatchSlots, {"tag": 10}, {"icu.slots": 16}, ({},)

    def model(self, config):
        """Each part on its own; it can be read in the cycle after it was written, not in the same one."""
        parts, pipeline = {name: {} for name, _ in IcuFormats(config).slot_record}, ShiftRegisters(2)
        given = yield
        while True:
            outputs, read = {"o": pipeline.end}, given.i
            writes = {name: getattr(given, f"i_{name}") for name in parts}
            pipeline.step(read and {"tag": read["tag"], "record": {
                name: None if writes[name] and writes[name]["slot"] == read["slot"] else part.get(read["slot"])
                for name, part in parts.items()}}, True)
            for name, write in writes.items():
                if write:
                    parts[name][write["slot"]] = write["part"]
            given = yield outputs
