"""The page of an exported core."""

from collections.abc import Mapping

from golden.engine.config import PRESETS
from radiosity.flow.package.flit_format import flit_text
from radiosity.flow.package.notice import LICENCE
from radiosity.flow.package.tops import TOPS

__all__ = ["readme"]

_README = """\
# {name}

{about}.

Written by `radiosity verilog --top {top} {settings}` of Radiosity Engine {version}; all parameters are in
`{name}.json`.

| file | is |
|---|---|
| `{name}.sv` | all modules in SystemVerilog, nothing else is needed; `{name}.f` lists it |
| `{name}.v` | the same in Verilog 2005, for tools without SystemVerilog |
| `{name}.json` | ports, parameters, latencies{more}, digest of `{name}.sv` |
| `{name}.sdc`, `.xdc`, `.lpf` | the clock, {mhz:g} MHz, for Quartus and others, Vivado, and nextpnr |
| `{name}.core` | for FuseSoC; its target `lint` runs Verilator{simulation} |
| `{name}.vhd` | a VHDL package with the component `{name}`, by which a VHDL design instantiates it |
| `LICENSE` | {licence}: copies retain its text and the notices in the files |
| `{name}.vlt` | waivers for the warnings of Verilator's `-Wall`, with reasons |{files}

{clocking}
{meaning}{host}
## The module

```verilog
{name} instance_name (
{connections}
);
```

| port | direction | bits |
|---|---|---|
{ports}
"""
_CLOCK = """\
Everything happens at the rising edge of `clk`. `rst` is synchronous and active high, one cycle of it is enough."""
_CLOCKS = """\
Everything happens at the rising edges of three clocks without a relation: the engine's is `clk`, that of `m_axi_*` is
`m_axi_aclk`, and that of `s_axil_*` and `irq` is `s_axil_aclk`. `rst` is active high, `m_axi_aresetn` and
`s_axil_aresetn` are active low. Each of them resets all three sides: at once, and until all clocks have had four edges
after the last of them has ended, and each its own two more. A clock that stands still holds all sides. Offers are
withdrawn at once: reset main memory and the host together with the engine, or reset only while no access is in
flight. Gray counters and synchronisers cross between the clocks. Synchronisers have the attribute `ASYNC_REG`. The
constraints bound the skew of each counter to a period (`set_bus_skew`, `set_max_skew`), and for Vivado also the delay
between clocks: if clocks differ, give the bounds the shortest of their periods. nextpnr times none of this."""
_ENGINE = """
* `s_axil_*` is an AXI4-Lite subordinate of 32 bits: [the registers](registers.md).
* `m_axi_*` is an AXI4 manager of {data} bits and {address} address bits. It reads and writes inside the windows that
  registers `read_base` to `write_limit` define, and nowhere else. [What is in memory](formats.md).
* `irq` is active high until the host acknowledges it: completion records have been written, or the queue has
  halted. It is 0 unless the register `interrupt` enables it.
"""
_ENGINE_FILES = """
| `registers.md`, `formats.md` | registers, errors, counters; descriptors, completion records, results, memory images |
| `{name}.rdl` | the registers in SystemRDL 2.0; PeakRDL writes pages, C headers and IP-XACT from it |
| `driver/radiosity.h`, `.c` | a driver in C99: the registers, jobs, completion records, errors, counters |
| `example/main.cpp`, `Makefile` | a simulation in Verilator: main memory behind AXI4, and the driver on AXI4-Lite |
| `example/cast_job.c`, `cast_job.h` | a job from `job.bin` to results, at any port of the driver |
| `example/decode.c`, `decode.py` | from the lines of results to distances in the scene, u, v and form factors |
| `litex_soc/radiosity_soc.py` | a module of LiteX: registers on the bus of a SoC, memory in its SDRAM |
| `litex_soc/simulation.py`, `uartbone.c`, `Makefile` | a SoC in LiteX's simulator, and a host that casts over TCP |
| `litex_soc/ulx3s.py` | the same SoC at the pins of a ULX3S with an ECP5-85; the host casts over its USB socket |"""
_JOB_FILES = """
| `job/job.bin`, `.h`, `.txt` | a small job: memory before the doorbell, its addresses, and the results |"""
# The sample exceeds a capacity of the engine.
_NO_JOB = ", and a job that fits this engine"
_HOST = """
## The first cast

`make -C example check` needs Verilator 5, make, gcc and g++ (`VERILATOR=PATH` names another Verilator){job}. It

1. translates `{name}.sv` to C++ and compiles it: a minute or two, once for all jobs;
2. compiles the driver, and `example/cast_job.c` and `main.cpp` with the addresses of `job.h`;
3. copies `job.bin` into the simulated main memory, gives the engine rings and windows, writes the doorbell, and waits
   for an interrupt for each completion record;
4. prints a line `hit FRUSTUM COLUMN ROW PATCH INVERSE U V` for each ray (patch -1: no hit), and `sum FRUSTUM PATCH SUM`
   for each patch: the form factor of the patch times 2^`RADIOSITY_JOB_WEIGHT_BITS`;
5. compares these lines with `job.txt`.

`radiosity image SCENE --manifest {name}.json --patch NUMBER --expected -o FOLDER` writes other jobs, and
`make -C example check JOB=FOLDER`, with an absolute path, casts them.

## The driver

`driver/radiosity.h` has the sequence of calls. The driver allocates nothing and needs no operating system: five
functions of the host read and write registers and main memory, and wait. If the host caches main memory, they write
back before a register is written, and invalidate after one is read. Without the driver:

1. Copy `job.bin` to its address, and clear the ring of completion records.
2. Read `magic` and `version`. Write `ring`, `completions`, `ring_bits`, `read_base` to `write_limit`, and `policy`.
3. Write the number of descriptors into `doorbell`, and read `completed` until it has reached that number.
4. Read the completion records: byte 60 of each is its error. The hits are where `job.h` says.

## In LiteX

`litex_soc/radiosity_soc.py` has `RadiosityEngine`, a module of LiteX, and `add_radiosity(soc)`, which connects it: the
registers to the bus of the SoC, `m_axi_*` to a port of LiteDRAM, `irq` to an event and, with a processor, to its
interrupts. `add_sdram` must have `l2_cache_size=0`: the engine does not see what that cache holds.

`make -C litex_soc check` casts `job` in LiteX's simulator: a SoC without a processor, 32 MB of SDRAM, and a bridge,
UARTBone, through which the driver in `uartbone.c` reads and writes over TCP. It needs
`pip install litex litedram migen pythondata-misc-tapcfg`, `verilator` on PATH, and the headers of libevent, json-c and
zlib. `PYTHON=PATH` names the Python that has LiteX, `JOB=FOLDER` another job, and `PORT=NUMBER`, from the first run on,
another TCP port than 1234.

`litex_soc/ulx3s.py` writes the SoC for the ULX3S: Verilog, constraints, and a script for Yosys and nextpnr. It needs
`litex-boards` too. `radiosity soc` makes a bitstream of such an engine. `make -C litex_soc board` casts `job` on a
board at `DEVICE=/dev/ttyUSB0`, and compares the results.
"""
_STREAMS = """
Ports named `*_valid`, `*_ready` and `*_payload` are streams: a transfer occurs at an edge at which both are high; a
stream without `*_ready` is always ready. The fields of a payload are in the manifest.
"""


_LINKS = """
## Links

{flits}
* Who sends on a channel counts the free entries of the receiver's queue: `noc.buffer_flits` of them at first, one less
  for each flit, one more for each cycle in which the channel's bit of the credit port is high. A link that leads
  nowhere has inputs of 0.
* A router's port 0 is its node's own; the others are those of the topology in the order of `example/network.v`.
"""
_NETWORK_EXAMPLE = """
## The example

`example/` has a network made of {parts}, of the topology of this configuration, that carries 10,000 flits: requests and
replies from every node to every node, while sources and sinks stall. Each flit must come in the cycle in which the
golden model has it. `make -C example check` needs Icarus Verilog, `make -C example verilator` Verilator 5.036 or newer,
and `make -C example cocotb` cocotb 2 (`SIM=verilator`: in Verilator). `given.hex` and `required.hex` have a word for
each cycle; `words.v` says which bits of it are which port.
"""
_STREAM_EXAMPLE = """
## The example

`example/` has benches in which {what}. They give streams the golden model's stimuli, compare what comes with its
results, and stall now and then. `make -C example check` needs Icarus Verilog, `make -C example verilator` Verilator
5.036 or newer, and `make -C example cocotb` cocotb 2 (`SIM=verilator`: in Verilator). Each stream has a file: a line is
an item's step and its bits, of outputs between them a mask of the bits that are compared. A step begins when all items
of those before have been given or have come. A file of requests has in each line a request and an item of its answer.
"""
# What happens in the bench of a unit.
_BENCHES = {
    "icu": "a hemisphere and a screen are cast in the Cornell box: patches go in; tokens, the settle map, all hits and "
           "all sums come out",
    "ctu": "a hemisphere's grid rays traverse the Cornell box, where most rays have been settled: all cells come out, "
           "each with its stage, those of a frustum in any order, because rays are traversed beside each other",
    "cluster": "a hemisphere is cast in a lobby of 227 patches, of which the cluster holds 16 and requests the others: "
               "all hits and sums come out as it writes them to main memory, and the end of the section. Of its "
               "completion record counters are not compared that depend on cycles",
}


def readme(top: str, name: str, facts: Mapping[str, object], *, mhz: float, has_job: bool, has_bench: bool) -> str:
    """The page as Markdown.

    Parameters
    ----------
    top, name, facts
        One of `TOPS`, the name of its module, and its manifest.
    mhz
        The clock of the constraints.
    has_job, has_bench
        The core has a job for its example, or an example with benches.
    """
    config, ports, is_engine = facts["parameters"], facts["ports"], TOPS[top].is_engine
    usual = PRESETS[facts["preset"]].parameters()
    changes = (f"-P {path}={value}" for path, value in config.items() if value != usual[path])
    meaning = _ENGINE.format(data=config["memory.data_bits"], address=config["memory.address_bits"]) if is_engine \
        else _STREAMS
    if TOPS[top].is_network:
        meaning += _LINKS.format(flits="\n".join(f"* {line}" for line in flit_text(facts["flit"])))
    if has_bench:
        meaning += _NETWORK_EXAMPLE.format(parts="exported routers" if top == "router" else "the module") \
            if TOPS[top].is_network else _STREAM_EXAMPLE.format(what=_BENCHES[top])
    more = ", registers, error codes, counters" if is_engine else ", counters" if "counters" in facts else ""
    return _README.format(
        top=top, name=name, licence=LICENCE, about=facts["about"], version=facts["version"],
        more=more,
        settings=" ".join([f"--preset {facts['preset']}", *changes]),
        simulation=", `sim` casts the sample job" * has_job,
        files=(_ENGINE_FILES.format(name=name) + _JOB_FILES * has_job) if is_engine else "", mhz=mhz,
        clocking=_CLOCKS if TOPS[top].buses else _CLOCK, meaning=meaning,
        host=_HOST.format(name=name, job="" if has_job else _NO_JOB) if is_engine else "",
        connections=",\n".join(f"  .{port['name']}({port['name']})" for port in ports),
        ports="\n".join(f"| `{port['name']}` | {port['direction']} | {port['width']} |" for port in ports))
