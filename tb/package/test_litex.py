"""The LiteX module beside an exported engine: in LiteX's simulator the driver casts exact hits through UARTBone.

Needs LiteX in an environment of its own, which `make litex` makes, and the headers of libevent, json-c and zlib.
"""

import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from hw.package.core_files import write_core
from tb.golden.commands.runner import run
from tb.package.exported_engine import CONFIG, NAME, WIDE, make

# In one process, which installs LiteX once.
pytestmark = pytest.mark.xdist_group("litex")
ROOT = Path(__file__).parents[2]
# A SoC of the exported module, with a bus and with interrupts as a processor enables them.
INTERRUPTED = """
from simulation import SimulatedSoC

class Interrupted(SimulatedSoC):
    def add_sdram(self, *arguments, **options):
        super().add_sdram(*arguments, **options)
        self.irq.enable()

soc = Interrupted()
print(soc.irq.locs, soc.bus.regions["radiosity"].size)
"""


@pytest.fixture(scope="module")
def litex():
    """The Python that has LiteX."""
    subprocess.run(["make", "--no-print-directory", "litex", f"PYTHON={sys.executable}"], cwd=ROOT, check=True)
    return ROOT / "build" / "litex" / "bin" / "python"


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def execute(python, folder, *arguments):
    """Of an exported folder, in the environment of LiteX alone."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run([python, *map(str, arguments)], cwd=folder / "litex_soc", capture_output=True, text=True,
                          check=False, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.nightly
@pytest.mark.parametrize("config", [CONFIG, WIDE], ids=["64 bits", "256 bits"])
def test_the_module_has_every_port_and_an_interrupt(config, litex, without_verilog, tmp_path):
    """Of memories as wide as LiteDRAM's ports can be made, and of addresses of 32 and 40 bits."""
    write_core("engine", config=config, preset="tiny", folder=tmp_path)
    execute(litex, tmp_path, "simulation.py", "build")
    verilog = (tmp_path / "litex_soc" / "build" / "gateware" / "sim.v").read_text()
    instance = verilog[verilog.index(f"\n{NAME} {NAME}("):]
    instance = instance[:instance.index("\n);")]
    ports = json.loads((tmp_path / f"{NAME}.json").read_text())["ports"]
    assert sorted(re.findall(r"\.(\w+)\s*\(", instance)) == sorted(port["name"] for port in ports)
    found = execute(litex, tmp_path, "-c", INTERRUPTED).splitlines()[-1]
    assert found == f"{{'radiosity': 0}} {1 << 15}"


@pytest.mark.nightly
def test_the_driver_casts_in_the_simulator_of_litex(litex, tmp_path):
    """The sample; then a job of eight frusta elsewhere in the SDRAM, with other hits; a wrong hit is noticed."""
    folder, job = tmp_path / "core", tmp_path / "job"
    subprocess.run([sys.executable, "-m", "hw", "verilog", "--preset", "tiny", "-P", "noc.columns=1", "-P",
                    "noc.rows=1", "-o", folder], check=True)
    options = f"PYTHON={litex}", f"PORT={free_port()}"
    make(folder / "litex_soc", "check", *options)
    results = folder / "litex_soc" / "build" / "results.txt"
    assert results.read_text().count("hit ") == 256
    patches = [option for patch in range(2, 10) for option in ("--patch", patch)]
    assert run("image", "cornell", "--manifest", folder / f"{NAME}.json", *patches, "--rays", "32x8", "--base",
               "0x1230000", "--sums", "--hits", "compact", "--expected", "-o", job).exit_code == 0
    expected = (job / "job.txt").read_text()
    assert expected.count("hit ") == 8 * 256
    (job / "job.txt").write_text(expected.replace("hit 3 7 5 ", "hit 3 7 6 ", 1))
    with pytest.raises(AssertionError, match="differ"):
        make(folder / "litex_soc", "check", f"JOB={job}", *options)
    assert results.read_text() == expected
