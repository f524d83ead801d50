"""The LiteX module beside an exported engine: in LiteX's simulator the driver casts exact hits through UARTBone.

Needs LiteX in an environment of its own, which `make litex` makes, and the headers of libevent, json-c and zlib.
"""

import json
import os
import pty
import re
import select
import socket
import subprocess
import sys
import threading
import time
import tty
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest

from golden.base.errors import InputError
from radiosity.flow.board.soc import NEXTPNR, SOC, build_soc
from radiosity.flow.package.core_files import write_core
from tb.radiosity.cli.golden.runner import run
from tb.radiosity.flow.package.exported_engine import CONFIG, NAME, WIDE, make

# In one process, which installs LiteX once.
pytestmark = pytest.mark.xdist_group("litex")
ROOT = Path(__file__).parents[4]
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


@contextmanager
def serial_line(folder, port):
    """LiteX's simulator behind a pseudoterminal: the device's name."""
    gateware, (ours, theirs) = folder / "litex_soc" / "build" / "gateware", pty.openpty()
    tty.setraw(theirs)
    with (gateware / "serial.log").open("w") as log:
        simulator = subprocess.Popen(["obj_dir/Vsim"], cwd=gateware, stdout=log, stderr=subprocess.STDOUT)

    def move(connection):
        while True:
            ready, _, _ = select.select([ours, connection], [], [])
            for end in ready:
                data = os.read(ours, 512) if end == ours else connection.recv(512)
                if not data:
                    return
                if end == ours:
                    connection.sendall(data)
                else:
                    os.write(ours, data)

    try:
        for _ in range(600):
            assert simulator.poll() is None, (gateware / "serial.log").read_text()
            try:
                connection = socket.create_connection(("127.0.0.1", port))
                break
            except OSError:
                time.sleep(0.1)
        mover = threading.Thread(target=move, args=(connection,), daemon=True)
        mover.start()
        yield os.ttyname(theirs)
    finally:
        # The connection ends with it, and so does the thread.
        simulator.kill()
        simulator.wait()
    mover.join()
    connection.close()
    for end in ours, theirs:
        os.close(end)


def addresses(folder, build):
    """Of a SoC's registers and memories."""
    rows = (folder / "litex_soc" / build / "csr.csv").read_text().splitlines()
    return [row for row in rows if row.startswith(("csr_", "memory_region"))]


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
    """The sample; then a job of eight frusta elsewhere in the SDRAM, with other hits; a wrong hit is noticed.

    The same job as on a board: at a serial line, by a host compiled for the SoC of the ULX3S.
    """
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
    (job / "job.txt").write_text(expected)
    with serial_line(folder, int(options[1].removeprefix("PORT="))) as device:
        make(folder / "litex_soc", "board", f"JOB={job}", f"DEVICE={device}", *options)
    assert (folder / "litex_soc" / "ulx3s" / "results.txt").read_text() == expected
    assert addresses(folder, "ulx3s") == addresses(folder, "build")


@pytest.mark.nightly
def test_the_soc_of_the_board_casts_a_hemisphere_of_room1627(litex, tmp_path):
    """With the engine of the bitstream; the commands are those of docs/board.md."""
    folder, job = tmp_path / "core", tmp_path / "job"
    subprocess.run([sys.executable, "-m", "hw", "soc", "--no-bitstream", "--litex", litex, "-o", folder], check=True)
    assert run("image", "room1627", "--manifest", folder / f"{NAME}.json", "--patch", 100, "--rays", "64x16", "--sums",
               "--expected", "-o", job).exit_code == 0
    make(folder / "litex_soc", "check", f"PYTHON={litex}", f"PORT={free_port()}", f"JOB={job}")
    results = (folder / "litex_soc" / "build" / "results.txt").read_text()
    assert (results.count("hit "), results.count("sum ")) == (1024, 105)


# Registers between all ports stand for the engine: synthesis removes nothing of the SoC.
STUB = """
module {name}({ports});
{declarations}
  reg [{inputs}:0] given; reg [{outputs}:0] made;
  always @(posedge clk) begin given <= {{{taken}}}; made <= {{made, ^given}}; end
  assign {{{driven}}} = made;
endmodule
"""


def stub(ports):
    """The Verilog of an engine that does nothing, with the ports of a manifest."""
    driven = [port for port in ports if port["direction"] == "output"]
    taken = [port for port in ports if port not in driven and port["name"] not in ("clk", "rst")]
    names, widths = ([", ".join(port["name"] for port in some) for some in (ports, taken, driven)],
                     [sum(port["width"] for port in some) - 1 for some in (taken, driven)])
    declarations = "\n".join(f"  {port['direction']} [{port['width'] - 1}:0] {port['name']};" for port in ports)
    return STUB.format(name=NAME, ports=names[0], taken=names[1], driven=names[2], declarations=declarations,
                       inputs=widths[0], outputs=widths[1])


@pytest.mark.nightly
def test_a_bitstream_of_the_soc_for_the_ulx3s(litex, without_verilog, monkeypatch, tmp_path):
    """Of all but the engine; one that misses its clock is refused in a line and has no bitstream."""
    def write_stub(top, *, folder, **given):
        write_core(top, folder=folder, **given)
        ports = json.loads((folder / f"{NAME}.json").read_text())["ports"]
        (folder / f"{NAME}.sv").write_text(stub(ports))

    def build(hertz):
        return build_soc(SOC, tmp_path / str(hertz), litex=litex, hertz=hertz, baud=1_000_000, revision="2.0", seed=1,
                         options=NEXTPNR, stage=lambda name: nullcontext())

    monkeypatch.setattr("radiosity.flow.board.soc.write_core", write_stub)
    figures = build(40_000_000)
    # What an ECP5-85 begins with, and says that it is.
    assert b"LFE5U-85F" in Path(figures["output"][-2]).read_bytes()[:200]
    # The controller of the SDRAM, the bridge and the bus.
    assert 1000 < figures["lut"] < 6000
    assert figures["mhz"] >= 40
    constraints = Path(figures["output"][2]).read_text()
    # Of the board's schematics.
    sites = dict(re.findall(r'LOCATE COMP "([\w\[\]]+)" SITE "(\w+)"', constraints))
    assert len(sites) == 44
    assert {name: sites[name] for name in ("clk25", "serial_tx", "serial_rx", "sdram_clock", "sdram_dq[15]")} == {
        "clk25": "G2", "serial_tx": "L4", "serial_rx": "M1", "sdram_clock": "F19", "sdram_dq[15]": "J17"}
    with pytest.raises(InputError, match=r"nextpnr-ecp5 failed, .*: ERROR: Max frequency .* \(FAIL at 100.00 MHz\)$"):
        build(100_000_000)
    assert not list((tmp_path / "100000000").rglob("*.bit"))
