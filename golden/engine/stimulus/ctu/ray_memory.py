"""Stimulus of `golden.engine.ctu.ray_memory`."""

import numpy as np

from golden.engine.ctu.ray_memory import RayMemory
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import FLAG, Block, Field
from golden.engine.stimulus.ctu.grids import SHELL

__all__ = ["BLOCK"]

SLOTS, DEFERRED = 8, 4
NUMBER = unsigned(16, 0)


def _fields(config):
    return [Field("slots", NUMBER, "of the memory, all present, of version 0", constant=True),
            Field("deferred", NUMBER, "capacity of deferred requests", constant=True),
            Field("completes", FLAG, "the slot's ray returns; otherwise a subshell requests it"),
            Field("slot", NUMBER, "of the memory"), Field("subshell", NUMBER, "that requests"),
            Field("shell", SHELL, "requested")], [
        Field("looked_at", FLAG, "the request is accepted"),
        Field("leaves", FLAG, "the slot's ray is issued (again)"),
        Field("leaves_subshell", NUMBER, "for this subshell"), Field("leaves_shell", SHELL, "and shell"),
        Field("waiting", NUMBER, "deferred requests afterwards")]


def _draw(random, count, config):
    completes = random.random(count) < 0.4
    slot = random.integers(SLOTS, size=count)
    # Only a ray in flight returns.
    memory = RayMemory(SLOTS, deferred=DEFERRED)
    subshell = random.integers(16, size=count)
    shell = np.minimum(2 + np.arange(count) // 8, SHELL.high - 2) + random.integers(3, size=count)
    away = set()
    for number in range(count):
        if completes[number] and away:
            slot[number] = random.choice(sorted(away))
            away.discard(int(slot[number]))
            away |= {left for left, _, _ in memory.complete(slot[number:number + 1])}
        else:
            completes[number] = False
            leaving, _ = memory.request(slot[number:number + 1], subshell=int(subshell[number]),
                                        shell=int(shell[number]))
            away |= set(leaving.tolist())
    return {"slots": np.array(SLOTS), "deferred": np.array(DEFERRED), "completes": completes, "slot": slot,
            "subshell": subshell, "shell": shell}


def _expect(given, config):
    memory = RayMemory(int(given["slots"]), deferred=int(given["deferred"]))
    found = []
    for completes, slot, subshell, shell in zip(*(given[name] for name in (
            "completes", "slot", "subshell", "shell")), strict=True):
        accepted, again = 0, []
        if completes:
            again = memory.complete(np.array([slot]))
        else:
            leaving, accepted = memory.request(np.array([slot]), subshell=int(subshell), shell=int(shell))
            again = [(slot, subshell, shell)] if len(leaving) else []
        found.append((accepted, len(again), *(again[0][1:] if again else (0, 0)), len(memory.waiting)))
    return dict(zip(("looked_at", "leaves", "leaves_subshell", "leaves_shell", "waiting"), np.array(found).T,
                    strict=True))


BLOCK = Block(about="a request or a return, one after the other", fields=_fields, draw=_draw, expect=_expect)
