"""Illegal values of registers, descriptors and images: each ends in its code, and the next job is exact."""

import random
from collections import Counter

import numpy as np
import pytest

from golden.engine.jobs.descriptor import DESCRIPTOR, check_descriptor
from golden.engine.memory_map import ENTRY, HEADER, REGIONS
from golden.engine.memory_map.rules import RULES
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import WORD_BYTES, Access, addresses
from radiosity.flow.host import RegisterError
from tb.lib.seed import NIGHTS, SEED
from tb.system.job_machine import CLUSTERS, JobMachine, cornell, planned

KINDS = "register", "descriptor", "header", "record"


def number(draw, bits):
    """Of so many bits: often 0, one bit, or all of them."""
    return draw.choice((0, 1 << draw.randrange(bits), (1 << bits) - 1, draw.getrandbits(bits)))


def put(record, field, draw):
    """A drawn value of any bits in an element of a field."""
    elements = record[field].reshape(-1)
    size = elements.itemsize
    elements[draw.randrange(len(elements))] = np.array([number(draw, 8 * size)], f"<u{size}").view(elements.dtype)[0]


class IllegalValues:
    """A machine and a job of a load and the sections of two frusta, for values that it must refuse.

    Members
    -------
    found
        How often each kind of value ended in each code, or in SLVERR.
    """

    def __init__(self, clusters):
        self.job = planned(clusters, cornell(clusters, points=(5, 6), rays=(16, 8), cell=0.5, sets="scheduled",
                                             clusters=clusters))
        self.machine, self.found = JobMachine(self.job), Counter()
        self._sections = range(1, len(self.job.descriptors))
        self._unloaded = {tag: {"NOT_LOADED"} for tag in self._sections}
        self.image, self._address = self.job.phases[0].image, self.job.phases[0].address

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.machine.port.close()

    def draw(self, draw):
        """One value, and the next job."""
        kind = draw.choice(KINDS)
        self.machine.begin()
        code = getattr(self, f"_{kind}")(draw)
        self.found[kind, code] += 1
        self.machine.right()

    def _register(self, draw):
        """A value, an address or an access that is answered with SLVERR; the register keeps its value."""
        machine, memory = self.machine, self.job.config.memory.address_bits
        table, one, value = addresses(ENGINE_REGISTERS), None, draw.getrandbits(32)
        # Behind the last register.
        address = max(table.values()) + WORD_BYTES * draw.randrange(2, 1 << 8)
        for _ in range(draw.choice((0, 999))):
            one = draw.choice(ENGINE_REGISTERS)
            word, value = draw.randrange(one.words), number(draw, 32)
            address, legal = table[one.name] + WORD_BYTES * word, one.ones(memory) >> 32 * word & 0xFFFFFFFF
            if one.access is Access.READ or (one.access is Access.WRITE and (
                    value & ~legal or (one.most is not None and value > one.most))):
                break
        before = None if one is None else machine(machine.port.read(address))
        with pytest.raises(RegisterError):
            machine(machine.port.write(address, value))
        # Counters of time and of the network go on.
        assert one is None or one.name == "cycles" or machine(machine.port.read(address)) == before
        return "SLVERR"

    def _descriptor(self, draw):
        """Any field of a descriptor."""
        descriptors, tag = self.job.descriptors.copy(), draw.randrange(len(self.job.descriptors))
        one = descriptors[tag:tag + 1]
        legal, refusal = one.copy(), None
        for _ in range(999):
            one[:] = legal
            put(one, draw.choice([name for name in DESCRIPTOR.dtype.names if name != "tag"]), draw)
            if refusal := check_descriptor(one[0], self.job.config):
                break
        records = self.machine(self.machine.host.run(self.job, descriptors))
        (record,) = records[records["tag"] == tag]
        assert int(record["address"]) == refusal.byte, f"{refusal} names its field"
        # The tables of an earlier load stay.
        self._check(records, {tag: {refusal.code}})
        return refusal.code

    def _header(self, draw):
        """Magic, version, size, or offset or count of a region."""
        entry = HEADER.dtype.itemsize + ENTRY.dtype.itemsize * draw.randrange(len(REGIONS))
        beyond = self.image.size + 64 + number(draw, 40)
        legal = np.frombuffer(self.image.to_bytes(), "<u4", 2).tolist()
        at, size, value, code = draw.choice((
            (0, 4, legal[0] ^ 1 << draw.randrange(32), "IMAGE"), (4, 4, legal[1] ^ 1 << draw.randrange(32), "IMAGE"),
            # An image that is too short, a region not at a multiple of 64 or behind the image, too many records.
            (8, 8, draw.randrange(256), "REGION"), (entry, 8, number(draw, 40) | 1 << draw.randrange(6), "REGION"),
            (entry, 8, beyond & -64, "REGION"), (entry + 8, 8, beyond, "REGION")))
        self.machine.write(self._address + at, value.to_bytes(size, "little"))
        self._check(self.machine.run(), {0: {code}} | self._unloaded)
        return code

    def _record(self, draw):
        """A field that a rule is about, in any record of its region."""
        rule = draw.choice([rule for rule in RULES if len(self.image[rule.region])])
        records, which = self.image[rule.region].copy(), draw.randrange(len(self.image[rule.region]))
        field, broken = draw.choice(rule.fields), []
        for _ in range(999):
            records[which] = self.image[rule.region][which]
            put(records[which:which + 1], field, draw)
            image = {**self.image.regions, rule.region: records}
            broken = [one for one in RULES if one.region == rule.region and not one.holds(image)[which]]
            if rule in broken:
                break
        first = self._address + self.image.offsets[rule.region]
        self.machine.write(first + which * records.itemsize, records[which:which + 1].tobytes())
        if rule.region == "patches" and which not in self.image["residents"]["patch"]:
            # A cast reads it, or does not.
            self._check(self.machine.run(), {tag: {"PATH_BUS", "NONE"} for tag in self._sections})
            return "PATH_BUS"
        ends = self.machine.run()
        self._check(ends, {0: {one.kind.code for one in broken}} | self._unloaded)
        (load,) = ends[ends["tag"] == 0]
        assert int(load["address"]) == first, "the load names the region"
        return ErrorCode(int(load["error"])).name

    def _check(self, records, codes):
        """These descriptors end with one of their codes, all others without one and exactly."""
        found = {int(one["tag"]): ErrorCode(int(one["error"])).name for one in records}
        assert all(found[tag] in codes.get(tag, {"NONE"}) for tag in found), f"{found}, not {codes}"
        self.machine.check(records, {tag: ErrorCode[name] for tag, name in found.items() if name != "NONE"})


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("count", [8, pytest.param(40 * NIGHTS, marks=pytest.mark.nightly)])
def test_each_ends_in_its_code_and_the_next_job_is_exact(clusters, count):
    with IllegalValues(clusters) as values:
        for at in range(count):
            try:
                values.draw(random.Random(f"{SEED} {clusters} {at}"))
            except Exception as error:
                error.add_note(f"SEED={SEED}, value {at}")
                raise
    assert len({kind for kind, _ in values.found}) >= min(len(KINDS), count // 4), values.found
