"""The examples of exported units run from the folder of the export alone, and notice what is wrong."""

import re
import shutil
import subprocess
import sys

import pytest

from hw.package.example.link_example import FLITS
from tb.lib.runner import tools
from tb.package.exported_engine import written


def make(folder, *goal):
    """What a goal of the example's Makefile prints, and whether it passes."""
    with tools():
        done = subprocess.run(["make", "-C", folder / "example", *goal], capture_output=True, text=True,
                              check=False)
    return done.stdout, done.returncode == 0


def passes(folder, goal):
    text, is_right = make(folder, goal)
    assert is_right, text
    (flits,) = re.findall(r"^(\d+) flits in \d+ cycles, 0 cycles differ: PASS$", text, re.MULTILINE)
    assert int(flits) >= FLITS


@pytest.mark.icarus
@pytest.mark.sim
def test_four_exported_routers_carry_ten_thousand_flits(router, tmp_path):
    """Each in golden's cycle; a flit that differs in one bit is noticed."""
    folder, files = router
    assert files["example/network.v"].count(b"  radiosity_router router_") == 4
    passes(folder, "check")
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    words = files["example/required.hex"].decode().splitlines()
    number = next(number for number, word in enumerate(words) if word.strip("0") and not word.startswith("//"))
    words[number] = f"{int(words[number], 16) ^ 2:0{len(words[number])}x}"
    (tmp_path / "example" / "required.hex").write_text("\n".join(words))
    text, is_right = make(tmp_path, "check")
    assert not is_right
    assert "1 cycles differ: FAIL" in text


# Topology, channels, kinds of messages, arbitration.
NETWORKS = {"mesh": {}, "torus": {"noc.topology": "torus", "noc.columns": 4, "noc.virtual_channels": 2,
                                  "noc.networks": "virtual"},
            "ring": {"noc.topology": "ring", "noc.columns": 3, "noc.rows": 1, "noc.virtual_channels": 2,
                     "noc.arbitration": "age", "noc.router_cycles": 1, "noc.check": "crc", "noc.flit_bits": 40},
            "hypercube": {"noc.topology": "hypercube", "noc.columns": 4}}


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("network", NETWORKS)
@pytest.mark.parametrize("top", ["router", "network"])
def test_every_network_in_every_simulator(top, network, tmp_path):
    written(tmp_path, "--top", top, "--preset", "small",
            *(word for path, value in NETWORKS[network].items() for word in ("-P", f"{path}={value}")))
    for goal in "check", "verilator":
        passes(tmp_path, goal)
    for simulator in "icarus", "verilator":
        assert make(tmp_path, "cocotb", f"SIM={simulator}", f"PYTHON={sys.executable}")[1]
