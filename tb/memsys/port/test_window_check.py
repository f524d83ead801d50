"""Windows are compared in all of their 64 bits: none is cut off at the width of an address. Nor is a request."""

import functools
import random

from hw.memsys.port.fault import Fault
from hw.memsys.port.window_check import WindowCheck
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of

CHANGES = {"memory.address_bits": 48}
TOP, BEAT = 1 << CHANGES["memory.address_bits"], config_of(CHANGES).memory.beat_bytes
# Bases and limits beyond all addresses, and such that are within a beat.
WINDOWS = [(0, TOP), (0, TOP - BEAT), (0, TOP + BEAT), (0, (1 << 64) - 1), (0, 0), (TOP, TOP + 64), (TOP + 64, 1 << 63),
           (1 << 63, (1 << 63) + 64), (64, TOP + 32), (BEAT, 2 * BEAT), (BEAT, 2 * BEAT - 1), (BEAT + 1, 2 * BEAT),
           (4 * BEAT - 1, 9 * BEAT + 1), (4 * BEAT + 1, 9 * BEAT - 1)]


def vectors_of(window, seed, count=60):
    """Requests around the ends of a window and of memory, some of them not at a beat."""
    draw, (base, limit), requests, checked, faults = random.Random(seed), window, [], [], []
    for tag in range(count):
        end, beats = draw.choice((0, base, limit, TOP)), draw.choice((1, 1, 2, 4, 8))
        address = (end // BEAT + draw.randint(-9, 9)) * BEAT % (2 * TOP) + draw.choice((0, 0, 0, 0, 4))
        bad = address % BEAT > 0 or address < base or address + beats * BEAT > min(limit, TOP)
        requests.append({"address": address, "length": beats - 1, "tag": tag})
        first = address // BEAT % (TOP // BEAT)
        checked.append({"first": first, "last": (first + beats - 1) % (TOP // BEAT), "tag": tag, "bad": bad})
        faults += [{"code": Fault.READ_OUTSIDE.value, "address": first * BEAT}] if bad else []
    return Vectors(inputs={"i": requests}, expected={"o_fault": faults, "o": checked},
                   ports={"window": {"base": base, "limit": limit}})


class TestWindowCheck(Bench):
    component, changes, variants = WindowCheck, CHANGES, ({},)
    arguments = {"tag": 6, "fault": Fault.READ_OUTSIDE}
    cases = {str(window): functools.partial(lambda window, config: vectors_of(window, 1), window) for window in WINDOWS}

    def drawn(self, config, seed):
        return vectors_of(WINDOWS[seed % len(WINDOWS)], seed)
