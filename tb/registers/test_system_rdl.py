"""The registers in SystemRDL: third-party tools read from it what the hardware is made from."""

import subprocess
import sys
from pathlib import Path

import pytest
from systemrdl import RDLCompiler
from systemrdl.messages import MessagePrinter
from systemrdl.node import RegNode

from hw.cluster import COUNTERS
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS, register
from hw.registers.error_code import ErrorCode
from hw.registers.register import WORD_BYTES, Access, addresses
from radiosity.flow.package.system_rdl import system_rdl

NAME, CLUSTERS = "radiosity_engine", 3
BIN = Path(sys.executable).parent
# By access: whether software reads and writes, and whether the machine does.
ACCESS = {Access.READ: (True, False, False, True), Access.WRITE: (True, True, True, False),
          Access.COMMAND: (False, True, True, False), Access.CONTROL: (True, True, True, True)}


class Messages(MessagePrinter):
    """Every message is a failure."""

    def print_message(self, severity, text, src_ref):
        raise AssertionError(f"{severity.name}: {text}")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("rdl") / f"{NAME}.rdl"
    path.write_text(system_rdl(NAME, clusters=CLUSTERS))
    return path


@pytest.fixture(scope="module")
def top(path):
    compiler = RDLCompiler(message_printer=Messages())
    compiler.compile_file(str(path))
    return compiler.elaborate(NAME).top


def test_every_register_is_where_the_hardware_has_it(top):
    found = {node.inst_name: node for node in top.children() if isinstance(node, RegNode)}
    assert {name: node.absolute_address for name, node in found.items()} == addresses(ENGINE_REGISTERS)
    for one in ENGINE_REGISTERS:
        node = found[one.name]
        assert (node.size, node.get_property("accesswidth")) == (one.words * WORD_BYTES, 32)
        fields = list(node.fields())
        assert sum(field.width for field in fields) == one.width
        assert [field.inst_name for field in fields] == [field.name for field in one.fields] or not one.fields
        for field in fields:
            assert (field.is_sw_readable, field.is_sw_writable, field.is_hw_readable,
                    field.is_hw_writable) == ACCESS[one.access], field.get_path()


def test_reset_values(top):
    for one in ENGINE_REGISTERS:
        fields = list(top.get_child_by_name(one.name).fields())
        if one.access is not Access.READ:
            assert sum(field.get_property("reset") << field.low for field in fields) == one.reset, one.name
    assert top.find_by_path("policy.value").get_property("reset") == register("policy").reset == 1


def test_what_a_write_does(top):
    pending = top.find_by_path("interrupt.pending")
    assert pending.get_property("onwrite").name == "woclr"
    assert top.find_by_path("interrupt.enable").get_property("onwrite") is None
    assert all(field.get_property("singlepulse") for field in top.get_child_by_name("command").fields())


def test_error_codes_are_those_of_the_machine(top):
    codes = top.find_by_path("error.value").get_property("encode")
    assert {one.name: one.value for one in codes} == {one.name: one.value for one in ErrorCode}


def test_counters_of_each_cluster(top):
    files = [node for node in top.children(unroll=True) if not isinstance(node, RegNode)]
    stride = WORD_BYTES << COUNTER_BITS
    assert [node.absolute_address for node in files] == [COUNTERS_BASE + stride * k for k in range(CLUSTERS)]
    assert {node.inst_name: node.address_offset for node in files[-1].registers()} == {
        name: WORD_BYTES * k for k, name in enumerate(COUNTERS)}


def exported(kind, output, path, *options):
    done = subprocess.run([BIN / "peakrdl", kind, path, "-o", output, *options], capture_output=True, text=True,
                          check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("kind", ["html", "ip-xact", "regblock"])
def test_exporters_have_nothing_to_complain_of(kind, path, tmp_path):
    exported(kind, tmp_path / "output", path)
    written = [one for one in tmp_path.rglob("*") if one.is_file()]
    assert any(b"flit_stalls" in one.read_bytes() for one in written)


def test_the_c_header_has_the_same_addresses(path, tmp_path):
    """With `--instantiate` and `-b` it asserts the offset of every register."""
    exported("c-header", tmp_path / "registers.h", path, "-i", "-b", "ltoh")
    assert "static_assert(" in (tmp_path / "registers.h").read_text()
    (tmp_path / "use.c").write_text('#include <stddef.h>\n#include "registers.h"\n' + "".join(
        f"static_assert(offsetof({NAME}_t, {name}) == {offset}, \"{name}\");\n"
        for name, offset in addresses(ENGINE_REGISTERS).items()))
    subprocess.run(["gcc", "-std=c11", "-fsyntax-only", "use.c"], cwd=tmp_path, check=True)
