"""Exported cores: byte-identical each time, and accepted by third-party tools without a warning."""

import gc
import hashlib
import json
import re
import shutil
import subprocess
import sys
import warnings
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import pytest
from amaranth.hdl import Fragment, MemoryInstance
from amaranth.lib import wiring
from click.testing import CliRunner

from golden.base.without_collection import without_collection
from golden.engine.config import PRESETS
from golden.engine.noc.packing import reply_flits, request_flits
from hw.lib.black_box import flatten
from hw.registers.register import WORD_BYTES
from radiosity.cli.hw.main import main
from radiosity.flow.host import Host
from radiosity.flow.package.core_files import CROSSING_WAIVERS, WAIVERS, core_files
from radiosity.flow.package.notice import with_notice
from radiosity.flow.package.system_rdl import system_rdl
from radiosity.flow.package.tops import TOPS, Top
from radiosity.flow.package.unit_latencies import unit_latencies
from radiosity.flow.simulator.simulated_port import complete
from radiosity.flow.synthesis.history import read_history
from tb.lib.drawn import drawn
from tb.lib.runner import tools
from tb.radiosity.flow.package.exported_engine import waiting, written

ROOT = Path(__file__).parents[4]
BIN = Path(sys.executable).parent


def test_the_same_bytes_in_every_process(router, tmp_path):
    assert written(tmp_path, "--top", "router", "--preset", "small", hash_seed="17") == router[1]


def test_files_of_a_core(router):
    files = router[1]
    example = {f"example/{name}" for name in ("Makefile", "bench.v", "given.hex", "network.v", "required.hex",
                                              "test_bench.py", "words.v")}
    assert set(files) - example == {"LICENSE", "README.md", *(f"radiosity_router.{kind}" for kind in (
        "sv", "v", "json", "vlt", "f", "sdc", "xdc", "lpf", "vhd", "core"))}
    assert example <= set(files)
    assert b"Written by `radiosity verilog --top router --preset small` of" in files["README.md"]
    facts = json.loads(files["radiosity_router.json"])
    assert facts["sha256"] == hashlib.sha256(files["radiosity_router.sv"]).hexdigest()
    assert facts["parameters"] == PRESETS["small"].parameters()
    texts = [files[f"radiosity_router.{kind}"].decode() for kind in ("sv", "v")]
    for port in facts["ports"]:
        bits = "" if port["width"] == 1 else rf"[{port['width'] - 1}:0] "
        assert all(f"\n  {port['direction']} {bits}{port['name']};\n" in text for text in texts), port
        if "fields" in port:
            assert sum(field["width"] for field in port["fields"]) == port["width"]


def test_the_page_has_the_command_that_writes_the_core_again(tmp_path, monkeypatch):
    monkeypatch.setattr(Top, "verilog", lambda *_: "")
    command = ["--top", "router", "--preset", "tiny", "-P", "noc.columns=4", "-P", "noc.rows=2"]
    assert CliRunner().invoke(main, ["verilog", *command, "-o", str(tmp_path)]).exit_code == 0
    assert f"\nWritten by `radiosity verilog {' '.join(command)}` of" in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize("given", [None, 12.5])
def test_all_constraints_are_the_same_clock(given, monkeypatch):
    """The period for Vivado and Quartus, the frequency for nextpnr and in the text."""
    monkeypatch.setattr(Top, "verilog", lambda *_: "")
    files, period = core_files("router", config=PRESETS["tiny"], preset="tiny", period=given), given or 9
    for kind in "sdc", "xdc":
        assert re.findall(r"-period (\S+)", files[f"radiosity_router.{kind}"]) == [f"{period:g}"]
    assert files["radiosity_router.lpf"].splitlines()[1:] == [f'FREQUENCY PORT "clk" {1000 / period:g} MHZ;']
    assert re.findall(r"the clock, (\S+) MHz", files["README.md"]) == [f"{1000 / period:g}"]


def test_default_periods_have_been_reached():
    """By the last recorded route of the unit, and an engine's by the board's page."""
    routed = {record.unit: max(record.mhz) for record in read_history() if record.mhz}
    (soc,) = re.findall(r"The whole SoC routes, at \*\*([\d.]+) MHz\*\*", (ROOT / "docs" / "board.md").read_text())
    reached = {"engine": float(soc), "async_engine": float(soc), "cluster": routed["Cluster"],
               "icu": routed["IntersectionUnit"], "ctu": routed["TraversalUnit"],
               **dict.fromkeys(("network", "router"), routed["Router-32-1"])}
    assert reached.keys() == TOPS.keys()
    for top, mhz in reached.items():
        assert 0.9 * mhz < 1000 / TOPS[top].period <= mhz, top


@pytest.fixture
def without_job(monkeypatch):
    """Engines get no sample, whose making takes longest."""
    monkeypatch.setattr("radiosity.flow.package.software.software_files.sample_job", lambda *_, **__: {})


def test_an_engine_has_its_registers_in_system_rdl_and_counters_where_the_driver_reads_them(monkeypatch, without_job):
    monkeypatch.setattr(Top, "verilog", lambda *_: "")
    monkeypatch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})
    config, read = PRESETS["tiny"].replace({"noc.columns": 3, "noc.rows": 1}), []
    files = core_files("engine", config=config, preset="tiny")
    facts = json.loads(files["radiosity_engine.json"])
    assert files["radiosity_engine.rdl"] == with_notice(
        "radiosity_engine.rdl", system_rdl("radiosity_engine", clusters=3))
    assert "| `radiosity_engine.rdl` |" in files["README.md"]

    async def answer(address):
        read.append(address)
        return 0

    complete(Host(SimpleNamespace(read=answer), config).counters())
    counters = facts["counters"]
    assert read == [counters["base"] + cluster * counters["stride"] + number * WORD_BYTES
                    for cluster in range(3) for number in range(len(counters["names"]))]


def test_latencies_are_those_of_the_units_that_a_core_has(router):
    facts = json.loads(router[1]["radiosity_router.json"])
    assert facts["latencies"] == {
        "noc.InputQueue": 1, "noc.OutputPort": 2, "noc.Router": PRESETS["small"].noc.router_cycles + 1}


@pytest.mark.parametrize("columns", [2, 3])
def test_all_links_of_a_router_are_live(columns):
    """It has an output and a queue in each direction, also where each node has two links alone."""
    made = TOPS["router"].make(PRESETS["tiny"].replace({"noc.columns": columns, "noc.rows": 2}))
    parts = [name for _, name, _ in Fragment.get(made, None).subfragments]
    for kind in "output_", "queue_":
        assert len([name for name in parts if name.startswith(kind)]) == 5


def test_the_manifest_has_the_format_of_flits(router):
    """As golden packs them: what each field of a header says is where the format has it."""
    facts, config = json.loads(router[1]["radiosity_router.json"])["flit"], PRESETS["small"]
    values = {"source": 2, "destination": 1, "patch": 4711}
    for kind, flits, given in (
            ("request", request_flits(config, **values), values),
            ("reply", reply_flits(config, **values, surface=99, vertices=[(1, 2, 3)] * 4), values | {"surface": 99})):
        packet = facts["packets"][kind]
        assert packet["flits"] == len(flits)
        header = sum((data & (1 << facts["data_bits"]) - 1) << number * facts["data_bits"]
                     for number, (data, _, _) in enumerate(flits[:packet["header_flits"]]))
        assert {field["name"]: header >> field["low"] & (1 << field["width"]) - 1
                for field in packet["header"]} == given
    assert flits[0][0].bit_length() <= facts["data_bits"] + facts["check_bits"]
    texts = [router[1][name].decode() for name in ("radiosity_router.sv", "radiosity_router.v", "README.md")]
    assert all("A reply has 5: 1 of the header, destination 1:0, source 3:2, patch 16:4" in text for text in texts)


def test_latencies_of_black_boxes_are_listed():
    config = PRESETS["tiny"]
    found = unit_latencies(*(make(config) for make in (TOPS["engine"].make, *TOPS["engine"].parts)))
    assert {"memsys.MainMemoryPort", "control.JobControl", "icu.PatchSetup", "ctu.Survival"} <= set(found)
    assert found["icu.PatchSetup"] > found["icu.Screening"] > 0
    assert "ctu.RayMemory" not in found


def lint(folder, top, kind="sv"):
    """What Verilator says with all its warnings."""
    with tools():
        done = subprocess.run(["verilator", "--lint-only", "-Wall", "--top-module", f"radiosity_{top}",
                               f"radiosity_{top}.vlt", f"radiosity_{top}.{kind}"], cwd=folder, capture_output=True,
                              text=True, check=False)
    return done.stdout + done.stderr if done.returncode else ""


@pytest.mark.parametrize("kind", ["sv", "v"])
def test_nothing_to_complain_of(kind, router):
    assert not lint(router[0], "router", kind)


def test_complaints_are_heard(router, tmp_path):
    shutil.copytree(router[0], tmp_path, dirs_exist_ok=True)
    text = tmp_path / "radiosity_router.sv"
    text.write_text(text.read_text().replace("endmodule", "wire open, same; assign same = open; endmodule", 1))
    assert "UNDRIVEN" in lint(tmp_path, "router")


def test_fusesoc_takes_the_core(router, tmp_path):
    shutil.copytree(router[0], tmp_path, dirs_exist_ok=True)
    with tools():
        done = subprocess.run(
            [BIN / "fusesoc", "--cores-root", ".", "run", "--target=lint", "radiosity::radiosity_router"],
            cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(("arguments", "said"), [
    (["--top", "rooter"], "'rooter' is not one of"), (["-P", "icu.rays=5000"], "icu.rays"),
    (["-P", "icu.rats=4096"], "icu.rats"), (["-o", "/dev/null/core", "--top", "router"], "/dev/null")])
def test_bad_requests_are_one_line(arguments, said):
    result = CliRunner().invoke(main, ["verilog", *arguments])
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_components_that_are_only_inspected_leave_no_warning(monkeypatch):
    """Ports of a core are those of a component that is never elaborated."""
    monkeypatch.setattr(Top, "verilog", lambda *_: "")
    gc.collect()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        core_files("router", config=PRESETS["tiny"], preset="tiny")
        gc.collect()
    assert not caught


@pytest.mark.parametrize("preset", ["tiny", pytest.param("thesis", marks=pytest.mark.nightly)])
def test_every_part_of_an_engine_is_elaborated(preset):
    """No component is made and then forgotten, and none of its names hides another one."""
    gc.collect()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with without_collection():
            fragment = Fragment.get(TOPS["engine"].make(PRESETS[preset]), None)
        no_memory_or_signal_hides_its_module(fragment)
        del fragment
        gc.collect()
    assert not caught


def declared(fragment, path=()):
    """The paths of all memories inside, and of the signals that a module drives and that are no ports of it."""
    ports = {port for one in fragment.origins or () if isinstance(one, wiring.Component) for port, *_ in flatten(one)}
    driven = {signal.name for statements in fragment.statements.values() for statement in statements
              for signal in statement._lhs_signals()}
    yield from ((*path, name) for name in driven - ports)
    for part, name, _ in fragment.subfragments:
        if isinstance(part, MemoryInstance):
            yield (*path, name)
        else:
            yield from declared(part, (*path, name))


def no_memory_or_signal_hides_its_module(fragment):
    """Verilator warns (VARHIDDEN) of what has the name of the instance around it."""
    paths = set(declared(fragment))
    assert paths
    assert not [path for path in paths if path[-2:-1] == path[-1:]]


def test_names_of_a_cluster_hide_no_module():
    with without_collection():
        no_memory_or_signal_hides_its_module(Fragment.get(TOPS["cluster"].make(PRESETS["small"]), None))


def test_files_are_written_whole(tmp_path, monkeypatch):
    """A failure while a file is written leaves the file that was there."""
    def cut(path, text):
        with path.open("w") as file:
            file.write(text[:10])
        raise OSError("no space left")

    old = tmp_path / "registers.md"
    old.write_text("old")
    monkeypatch.setattr(Path, "write_text", cut)
    result = CliRunner().invoke(main, ["registers", "-o", str(old)])
    assert result.exit_code != 0
    assert old.read_text() == "old"
    assert list(tmp_path.iterdir()) == [old]


@pytest.mark.nightly
@pytest.mark.parametrize(("top", "preset"), drawn([*product(TOPS, PRESETS)], each=-(-len(TOPS) * len(PRESETS) // 3)))
def test_all_presets(top, preset, tmp_path):
    first, again = (written(tmp_path / f"{k}", "--top", top, "--preset", preset, hash_seed=f"{k}") for k in range(2))
    assert first == again
    for kind in "sv", "v":
        text = first[f"radiosity_{top}.{kind}"].decode()
        assert not waiting(text)
        assert "ram_style" not in text
        assert not lint(tmp_path / "0", top, kind)


@pytest.mark.nightly
def test_latencies_of_the_engine(tmp_path):
    facts = json.loads(written(tmp_path, "--top", "engine", "--preset", "tiny")["radiosity_engine.json"])
    assert facts["latencies"]["icu.PatchSetup"] > 0


@pytest.mark.nightly
def test_every_waiver_is_needed(tmp_path):
    written(tmp_path, "--top", "icu", "--preset", "tiny")
    waivers = tmp_path / "radiosity_icu.vlt"
    lines = waivers.read_text().splitlines()
    needed = set()
    for rule in WAIVERS:
        waivers.write_text("\n".join(line for line in lines if f"-rule {rule} " not in line) + "\n")
        if f"-{rule}:" in lint(tmp_path, "icu"):
            needed.add(rule)
    # Those that the intersection unit has no case of.
    assert set(WAIVERS) - needed <= {"CASEINCOMPLETE"}


def test_the_page_names_every_waiver():
    page = (ROOT / "docs" / "verilog.md").read_text()
    assert set(WAIVERS | CROSSING_WAIVERS) <= set(re.findall(r"`([A-Z]+)`", page))


def test_each_bus_with_a_clock_of_its_own_has_it_in_all_files(monkeypatch, without_job):
    monkeypatch.setattr(Top, "verilog", lambda *_: "")
    monkeypatch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})
    files = core_files("async_engine", config=PRESETS["tiny"], preset="tiny")
    facts = json.loads(files["radiosity_async_engine.json"])
    ports = {port["name"]: port["direction"] for port in facts["ports"]}
    clocks = ["clk", "m_axi_aclk", "s_axil_aclk"]
    assert [facts["clock"]["port"], *(bus["clock"]["port"] for bus in facts["buses"])] == clocks
    assert [bus["reset"] for bus in facts["buses"]] == [
        {"port": f"{bus}_aresetn", "active": "low", "synchronous": False} for bus in ("m_axi", "s_axil")]
    assert not facts["reset"]["synchronous"]
    for port in *clocks, "m_axi_aresetn", "s_axil_aresetn":
        assert ports[port] == "input"
    for suffix in "sdc", "xdc":
        assert re.findall(r"create_clock .*", files[f"radiosity_async_engine.{suffix}"]) == [
            f"create_clock -name {clock} -period 25 [get_ports {clock}]" for clock in clocks]
    assert files["radiosity_async_engine.sdc"].splitlines()[-1] == (
        "set_clock_groups -asynchronous -group {clk} -group {m_axi_aclk} -group {s_axil_aclk}")
    assert files["radiosity_async_engine.lpf"].splitlines()[1:] == [f'FREQUENCY PORT "{clock}" 40 MHZ;'
                                                                   for clock in clocks]
    assert all(f"lint_off -rule {rule} " in files["radiosity_async_engine.vlt"] for rule in CROSSING_WAIVERS)
    example = files["example/main.cpp"]
    assert "top.clk = top.m_axi_aclk = top.s_axil_aclk = 1;" in example
    assert "top.m_axi_aresetn = 1;\n        top.s_axil_aresetn = 1;\n        top.rst = 1;" in example
    assert "three clocks without a relation" in files["README.md"]
