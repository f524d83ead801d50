"""Corrupted flits: the machine is reset, and names node and fault; a resumed queue is right."""

import numpy as np
import pytest

from hw.registers.error_code import ErrorCode
from tb.lib.configurations import config_of
from tb.system.faulty_receiver import faulty_machine
from tb.system.job_machine import SMALL, TWO_CLUSTERS, JobMachine, cornell, planned

CODES = {"data": ErrorCode.NETWORK_CHECK, "last": ErrorCode.NETWORK_ORDER, "destination": ErrorCode.NETWORK_ADDRESS}


@pytest.mark.nightly
@TWO_CLUSTERS
@pytest.mark.parametrize(("check", "faults"), [("parity", ("data",)), ("none", ("last", "destination"))])
def test_a_corrupted_flit_resets_the_machine(check, faults):
    """Check bits find each of them; without check bits a packet has a wrong length, or is at a wrong node."""
    config = config_of(SMALL | {"noc.columns": 2, "noc.check": check})
    job = planned(2, cornell(2, points=(5, 6, 9, 10, 0, 3), sets="scheduled"))
    with JobMachine(job, library=faulty_machine(config, *faults)) as machine:
        for number, fault in enumerate(faults):
            if number:
                machine(machine.host.command("stop"))
            machine.begin()
            if number:
                machine.resumed()
            machine.submit()
            records = machine.ended()
            assert machine(machine.host.read("error")) == CODES[fault].value
            assert machine(machine.host.read("error_cluster")) in (0, 1)
            found = {int(one["tag"]): ErrorCode(int(one["error"])) for one in records if one["error"]}
            assert {*found.values()} <= {CODES[fault], ErrorCode.ABORTED}
            assert [*found.values()].count(CODES[fault]) <= 1
            records += machine.resumed()
            machine.check(np.array(records), found)
        machine.right()
