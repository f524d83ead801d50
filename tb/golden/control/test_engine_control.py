"""The engine's control says what its documents say."""

import pytest

from golden.control.engine_control import COMMANDS, EARLIER, EngineControl, Fault, Inputs

NODES = 2
TAKES = 5


class Engine:
    """The model with units that take some cycles each."""

    def __init__(self):
        self._model, self._left = EngineControl(nodes=NODES), {}
        self.ends, self.watchdog, self.cluster = Fault(), 0, Fault()

    def step(self, command=None):
        """One cycle."""
        given = Inputs(
            command=None if command is None else 1 << COMMANDS.index(command.split()[0]), is_earlier=command == EARLIER,
            busy=frozenset(self._left), watchdog=self.watchdog, clusters=(Fault(), self.cluster),
            networks=(Fault(),) * NODES,
            ends={name: self.ends for name, left in self._left.items() if left == 1 and name != "cast"})
        said = self._model.step(given)
        self._left = {name: left - 1 for name, left in self._left.items() if left > 1 and not said.stops}
        if said.starts:
            self._left[said.starts] = TAKES
        return said

    def order(self, command):
        """What a command starts, or its error, and then the error is cleared."""
        self.step(command)
        said = self.step()
        if said.error:
            self.step("clear")
        return said.starts or (said.error.code if said.error else None)

    def finish(self):
        """Step until nothing is in flight."""
        while any(self.step().status[f"{name}s"] for name in ("load", "cast", "write", "stop")):
            pass


@pytest.mark.parametrize(("orders", "said"), [
    # An order with a comma is given when what is in flight has ended.
    ("cast", "NOT_LOADED"), ("write", "COMMAND"), ("write earlier", "COMMAND"), ("load", "load"),
    ("load, cast", "cast"), ("load, load, cast", "cast"), ("load, cast, clear, cast", "cast"),
    ("load cast", "COMMAND"), ("load load", "COMMAND"), ("load, cast write", "COMMAND"),
    ("load, cast, write", "write"), ("load, cast, write cast", "COMMAND"), ("load, cast, write earlier", "COMMAND"),
    ("load, cast, cast write earlier", "write"), ("load, cast, cast, write earlier", "write"),
    ("load, stop, cast", "NOT_LOADED"), ("load, cast, stop, load, write", "COMMAND")])
def test_orders(orders, said):
    engine, last = Engine(), None
    for group in orders.split(", "):
        engine.finish()
        for name in group.replace("write earlier", "earlier").split():
            last = engine.order(EARLIER if name == "earlier" else name)
    assert last == said


def test_a_faulty_load_is_forgotten():
    engine = Engine()
    assert engine.order("load") == "load"
    engine.ends = Fault("POINTER", 0, 64)
    engine.finish()
    assert engine.step().error == Fault("POINTER", 0, 64)
    engine.step("clear")
    assert engine.order("cast") == "NOT_LOADED"


def test_the_first_error_stays():
    engine = Engine()
    engine.step("cast")
    engine.cluster = Fault("PATH_CELL", 0, 7)
    for _ in range(5):
        assert engine.step().error == Fault("NOT_LOADED")
    engine.step("clear")
    for _ in range(1 + NODES):
        engine.step()
    assert engine.step().error == Fault("PATH_CELL", 1, 7)


@pytest.mark.parametrize(("watchdog", "expires"), [(0, False), (TAKES, True), (TAKES + 1, False), (1000, False)])
def test_the_watchdog(watchdog, expires):
    engine = Engine()
    engine.watchdog = watchdog
    assert engine.order("load") == "load"
    engine.finish()
    said = [engine.step() for _ in range(5)]
    assert (said[-1].error == Fault("WATCHDOG")) == expires
    assert said[-1].status["loaded"] != expires
