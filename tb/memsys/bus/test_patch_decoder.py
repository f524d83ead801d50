from golden.engine.memory_map import COORDINATE_BITS
from hw.memsys.bus.patch_decoder import FIRST_VERTEX, PatchDecoder
from tb.lib.bench import Bench
from tb.memsys.patch_words import words_of


class TestPatchDecoder(Bench):
    component, variants = PatchDecoder, ({},)

    def model(self, config):
        """Words of drawn patches, with gaps in which anything is at the ports."""
        self.words, self.next = [], None
        given = yield
        while True:
            word, vertex = given.word, given.valid and given.word >= FIRST_VERTEX
            head = given.valid and not word
            given = yield {
                "patch": self.patch[0] if head else None, "surface": self.patch[1] if head else None,
                "index": word - FIRST_VERTEX if vertex else None,
                "vertex": self.patch[2][word - FIRST_VERTEX] if vertex else None}

    def drive(self, given, random):
        """The words of one patch after the other."""
        if given.valid:
            if not self.words:
                self.patch = random.getrandbits(32), random.getrandbits(32), [
                    [random.getrandbits(COORDINATE_BITS) for _ in range(3)] for _ in range(4)]
                self.words = [*enumerate(words_of(*self.patch))]
            given.word, given.data = self.words.pop(0)
