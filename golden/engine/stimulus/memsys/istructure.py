"""Stimulus of `golden.engine.memsys.patches.istructure`."""

import numpy as np

from golden.engine.lib.fixed import signed, unsigned
from golden.engine.memsys.patches.istructure import IStructure
from golden.engine.stimulus.block import FLAG, Block, Field, padded

__all__ = ["BLOCK"]

COUNT, DEFERRED = 8, 4
NUMBER = unsigned(16, 0)
KIND = unsigned(2, 0)
READ, WRITE, START = range(3)


def _fields(config):
    return [Field("count", NUMBER, "locations", constant=True),
            Field("deferred", NUMBER, "capacity of deferred reads", constant=True),
            Field("kind", KIND, f"{READ} a read, {WRITE} a write, {START} a new version"),
            Field("address", NUMBER, "of the location"),
            Field("value", NUMBER, "tag of the read, data of the write")], [
        Field("taken", FLAG, "accepted; 0: no capacity for a read, a location already written, or a start while reads "
                             "are deferred"),
        Field("answered", signed(16, 0), "tags of the reads that are answered now, oldest first"),
        Field("data", NUMBER, "of the answers"),
        Field("waiting", NUMBER, "deferred reads afterwards")]


def _draw(random, count, config):
    return {"count": np.array(COUNT), "deferred": np.array(DEFERRED),
            "kind": random.choice([READ, WRITE, START], size=count, p=[0.6, 0.3, 0.1]),
            "address": random.integers(COUNT, size=count), "value": np.arange(count) % NUMBER.high}


def _expect(given, config):
    memory = IStructure(int(given["count"]), deferred=int(given["deferred"]))
    taken, answered, data, waiting = [], [], [], []
    for kind, address, value in zip(*(given[name].tolist() for name in ("kind", "address", "value")), strict=True):
        if kind == START:
            done, tags = memory.start(), []
        else:
            done, tags = (memory.read if kind == READ else memory.write)(address, value)
        taken.append(done)
        answered.append(np.array(tags, dtype=np.int64))
        data.append(memory.value(address) if tags else 0)
        waiting.append(memory.level)
    return {"taken": np.array(taken), "answered": padded(answered), "data": np.array(data),
            "waiting": np.array(waiting)}


BLOCK = Block(about="an access, one after the other", fields=_fields, draw=_draw, expect=_expect)
