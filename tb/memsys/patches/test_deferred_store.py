"""Items of released chains in their order."""

from collections import deque

from hw.memsys.patches.deferred_store import DeferredStore
from tb.lib.bench import Bench

OWNERS = 3


class TestDeferredStore(Bench):
    component, arguments, variants, span = DeferredStore, {"shape": 16, "depth": 6, "tag": 12}, ({},), 400

    def model(self, config):
        """Chains leave one after the other, each from its first item; what is free is used again in its order."""
        depth = self.arguments["depth"]
        self.chains, self.adds, self.frees, waiting = [None] * OWNERS, None, None, 0
        free, released, walked, shown = deque(range(depth)), deque(), deque(), None
        given = yield
        while True:
            takes, new = given.i is not None and waiting < depth, free[0] if free else None
            chain = takes and (self.chains[self.adds] or [])
            moves = given.o or shown is None
            leaves = bool(walked) and moves
            outputs = {
                "i": waiting < depth, "o": shown, "waiting": waiting,
                "longer": {"some": 1, "first": chain[0][0] if chain else new, "last": new} if takes else None,
                "releases": bool(given.i_release or released or walked or shown)}
            if takes:
                self.chains[self.adds] = [*chain, (free.popleft(), given.i["tag"])]
                self.adds = None
            if moves:
                shown = {"tag": walked[0][1], "data": walked[0][2]} if walked else None
            if leaves:
                free.append(walked.popleft()[0])
            if not walked and released:
                walked.extend(released.popleft())
            if given.i_release:
                released.append([(*item, given.i_release["data"]) for item in self.chains[self.frees]])
                self.chains[self.frees] = None
            waiting += takes - leaves
            given = yield outputs

    def items(self, name, shape, random):
        """Items of any owner. A chain that an item enters is not released; what says that there is none is garbage."""
        for number, item in enumerate(super().items(name, shape, random)):
            if name == "i":
                self.adds = random.randrange(OWNERS)
                yield {"tag": number, "chain": self._chain(self.chains[self.adds], item["chain"])}
                continue
            some = [one for one, chain in enumerate(self.chains) if chain and one != self.adds]
            self.frees = random.choice(some) if some and random.random() < 0.4 else None
            yield None if self.frees is None else item | {
                "chain": self._chain(self.chains[self.frees], item["chain"])}

    @staticmethod
    def _chain(chain, garbage):
        return {"some": 1, "first": chain[0][0], "last": chain[-1][0]} if chain else {**garbage, "some": 0}


class TestOneEntry(TestDeferredStore):
    arguments = {**TestDeferredStore.arguments, "depth": 1}
    constant, test_in_the_simulator = ("longer",), None
