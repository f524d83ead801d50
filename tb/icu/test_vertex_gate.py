from hw.formats import VERTICES
from hw.icu.vertex_gate import VertexGate
from tb.lib.bench import Bench


class TestVertexGate(Bench):
    component, variants = VertexGate, ({},)

    def model(self, config):
        """A patch begins while it is open; what has begun or has been offered passes whenever it closes."""
        vertex, is_offered = 0, False
        given = yield
        while True:
            passes = bool(given.is_open or vertex or is_offered)
            item = given.i if passes else None
            moves = item is not None and given.o
            outputs = {"o": item, "i": given.o and passes, "begins": moves and vertex == 0}
            is_offered, vertex = item is not None and not given.o, (vertex + moves) % VERTICES
            given = yield outputs

    def drive(self, given, random):
        """Mostly closed."""
        given.is_open = random.random() < 0.2
