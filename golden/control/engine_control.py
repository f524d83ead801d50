"""Engine control: which command begins when, and the registers ``status`` and ``error``."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from golden.memory_map import REGIONS

__all__ = ["ACTIVITIES", "ALL_REGIONS", "COMMANDS", "EARLIER", "RESETS", "EngineControl", "Fault", "Inputs", "Outputs"]

# Commands from bit 0 of the register on.
COMMANDS = ("stop", "clear", "load", "cast", "write")
# A write of the frustum before the present one has a rule of its own.
EARLIER = "write earlier"
# By command: what it starts, what may be in flight beside it, what must hold, and the error if that does not hold.
RULES = {
    "load": ("load", (), None, None),
    "cast": ("cast", (), "loaded", "NOT_LOADED"),
    "write": ("write", (), "present", "COMMAND"),
    EARLIER: ("write", ("cast",), "earlier", "COMMAND"),
}
ACTIVITIES = ("load", "cast", "write")
# Errors that leave units in an undefined state.
RESETS = {"PATH_TIMEOUT", "NETWORK_CHECK", "NETWORK_ORDER", "NETWORK_ADDRESS", "WATCHDOG"}
# Regions that a cast needs, as bits of the register ``regions``. `residents` is not loaded: the load of `patches` reads
# it.
ALL_REGIONS = sum(1 << number for number, region in enumerate(REGIONS)
                  if region.life != "result" and region.name != "residents")


@dataclass(frozen=True)
class Fault:
    """What the register ``error`` shows: code, cluster, and address or number."""

    code: str = "NONE"
    cluster: int = 0
    number: int = 0

    def __bool__(self):
        return self.code != "NONE"


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """Inputs of the control in a cycle.

    Parameters
    ----------
    command
        A write to the register ``command``, or none.
    regions, watchdog, is_earlier
        The registers ``regions``, ``watchdog`` and ``results.earlier``.
    busy
        Activities that are busy.
    memory_busy
        Main memory has an outstanding transaction.
    ends
        Loads and writes that end in this cycle, each with its fault.
    memory, clusters, networks
        Faults of the port, of each cluster and of each network interface.
    """

    command: int | None = None
    regions: int = ALL_REGIONS
    watchdog: int = 0
    is_earlier: bool = False
    busy: frozenset[str] = frozenset()
    memory_busy: bool = False
    ends: Mapping[str, Fault] = field(default_factory=dict)
    memory: Fault = Fault()
    clusters: tuple[Fault, ...]
    networks: tuple[Fault, ...]

    @property
    def command_name(self) -> str | None:
        """The command by name; of several the lowest bit counts; "none" if no bit is set."""
        if self.command is None:
            return None
        name = next((name for bit, name in enumerate(COMMANDS) if self.command >> bit & 1), "none")
        return EARLIER if name == "write" and self.is_earlier else name


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """Outputs of the control in a cycle.

    Parameters
    ----------
    starts
        The activity that starts.
    stops
        Units are reset.
    clear
        Faults are cleared.
    status, error
        The registers.
    """

    starts: str | None
    stops: bool
    clear: bool
    status: Mapping[str, bool]
    error: Fault


class EngineControl:
    """The engine's control by its rules, one cycle per step.

    Parameters
    ----------
    nodes
        Number of clusters.
    """

    def __init__(self, *, nodes: int):
        self._nodes, self._polled, self._cycle = nodes, (), 0
        self._starts, self._stops, self._error = None, False, Fault()
        self._loaded = self._present = self._earlier = False
        # The load in flight is of all regions; cycles since the last start while anything is in flight.
        self._complete, self._age, self._expired = False, 0, False

    def step(self, given: Inputs) -> Outputs:
        """The outputs in the cycle with these inputs."""
        command, in_flight = given.command_name, given.busy | {self._starts} - {None}
        outputs = Outputs(
            starts=self._starts, stops=self._stops, clear=self._stops or command == "clear", error=self._error,
            status={**{f"{name}s": name in in_flight for name in ACTIVITIES}, "stops": self._stops,
                    "loaded": self._loaded, "failed": bool(self._error), "present": self._present,
                    "earlier": self._earlier})
        refusal = self._refusal(command, in_flight)
        resets = command == "stop" or self._expired or any(one.code in RESETS for one in self._polled)
        starts = None
        if command in RULES and not refusal and not resets and not self._stops:
            starts = RULES[command][0]
        self._keep_error(given, command, refusal)
        self._poll(given, outputs.clear)
        self._watch(given, in_flight)
        self._keep_frusta(given)
        self._stops = given.memory_busy if self._stops else resets
        self._starts = starts
        self._cycle += 1
        return outputs

    def _refusal(self, command, in_flight):
        """The error of a command that is not possible."""
        if command == "none":
            return "COMMAND"
        if command not in RULES:
            return None
        _, beside, needs, error = RULES[command]
        if self._starts or self._stops or in_flight - set(beside):
            return "COMMAND"
        return error if needs and not getattr(self, f"_{needs}") else None

    def _keep_error(self, given, command, refusal):
        """The first error stays until it is cleared; an event in the cycle of a clear comes after it."""
        if command == "clear":
            self._error = Fault()
        if self._error:
            return
        found = [Fault("WATCHDOG" if self._expired else "NONE"),
                 *(given.ends.get(name, Fault()) for name in ACTIVITIES)]
        if command != "clear":
            found += [given.memory, Fault(refusal or "NONE"), *self._polled]
        self._error = next(filter(None, found), Fault())

    def _poll(self, given, clear):
        """One cluster per cycle, in turn; its own fault comes before that of its network interface."""
        number = self._cycle % self._nodes
        found = () if clear else (given.clusters[number], given.networks[number])
        self._polled = tuple(Fault(one.code, number, one.number) for one in found if one)

    def _watch(self, given, in_flight):
        """The watchdog counts the cycles since the last start in which anything is in flight."""
        self._expired = not self._stops and 0 < given.watchdog < self._age
        if self._stops or not in_flight:
            self._age = 0
        else:
            self._age = 1 if self._starts else self._age + 1

    def _keep_frusta(self, given):
        """Remember what is loaded, and whether one or two frusta have been started; a reset clears both."""
        if self._starts == "load":
            self._complete = given.regions & ALL_REGIONS == ALL_REGIONS
        if "load" in given.ends:
            self._loaded = not given.ends["load"] and (self._loaded or self._complete)
        if self._starts == "cast":
            self._present, self._earlier = True, self._present
        if self._stops:
            self._loaded = self._present = self._earlier = False
