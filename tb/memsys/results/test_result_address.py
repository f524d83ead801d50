from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat
from hw.memsys.results.result_address import ResultAddress
from tb.lib.bench import Bench
from tb.lib.configurations import config_of
from tb.memsys.results.extent import extent_of
from tb.memsys.section_results import drawn_section

FORMATS = [HitFormat.FULL, HitFormat.COMPACT, HitFormat.IDS]


class TestResultAddress(Bench):
    component, span = ResultAddress, 400
    # The latency of a component is that of the last row.
    formula = {"first_row": (1 << len(ResultAddress(config=config_of({})).i.payload.section.first_row)) - 1}
    variants = [*({"memory.data_bits": bits} for bits in (64, 128, 256, 512)), {"memory.address_bits": 16}]

    def model(self, config):
        """The address of the first hit, and the lanes to the next row, as many cycles after the command's offer as its
        first row has bits, and three.
        """
        cycles, extent = 0, None
        given = yield
        while True:
            due = given.i is not None and cycles >= 2 + given.i["section"]["first_row"].bit_length()
            ready = due and extent is None
            outputs, cycles = {"i": ready, "o": extent}, 0 if given.i is None or ready else cycles + 1
            if extent and given.o:
                extent = None
            if ready:
                extent = extent_of(given.i, config)
            given = yield outputs

    def items(self, name, shape, random):
        """Sections of small frusta and of large ones, and the last rays of the largest one; many at memory's end."""
        config = self.config()
        side, top = 1 << config.icu.side_bits, 1 << shape["hits"].width
        last = Sector(side - 1, side, side - 1, side)
        yield drawn_section(1, config, columns=side, section=last, hit_format=HitFormat.FULL, base=top >> 1,
                            sums_address=0).command_item
        while True:
            yield drawn_section(random.getrandbits(30), config, side=random.choice((8, 1 << 10)), sums_address=0,
                                base=random.choice((4096, top - 1024)), hit_format=random.choice(FORMATS)).command_item

