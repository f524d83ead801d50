"""Figures and lists of pages that no command prints, or none in a commit's tests."""

import re
from itertools import pairwise

from benchmarks.lanes import added_area
from golden.engine.config import PRESETS
from hw.board.frame import CHECK_BYTES, HEADER_BYTES
from hw.board.program import Operation
from radiosity.flow.board.record import record
from radiosity.flow.board.view import board_view
from radiosity.flow.synthesis.history import MACHINE, last_records, machine_parameters, read_history
from tb.docs.language import ROOT
from tb.docs.page_commands import commands_of


def test_bytes_of_a_view():
    program = record(board_view(PRESETS["board"], scene="cornell", pixels=(64, 64), cell=0.25).job)
    # The frames of a cast; an error's frame replaces those that remain.
    steps = program.steps[:program.error]
    frames = sum(step.operation == Operation.FRAME for step in steps)
    size = (frames * (HEADER_BYTES + CHECK_BYTES) + 4 * sum(step.operation == Operation.WORD for step in steps)
            + sum(step.value for step in steps if step.operation == Operation.BYTES))
    quoted, = re.findall(r"A view of 64 x 64 rays is ([\d,]+) bytes", (ROOT / "docs" / "board.md").read_text())
    assert quoted.replace(",", "") == str(size)


def test_every_module_of_the_memory_system_is_on_a_page():
    text = "\n".join((ROOT / "docs" / name).read_text() for name in (
        "architecture.md", "main-memory.md", "memory-path.md", "caches.md", "traversal-unit.md"))
    modules = {path.stem for path in (ROOT / "hw" / "memsys").rglob("*.py")} - {"__init__"}
    named = set(re.findall(r"`(?:hw/memsys/(?:\w+/)?)?(\w+?)(?:\.py)?`", text))
    assert {module for module in modules if not {module, module.title().replace("_", "")} & named} == set()


def test_the_status_table_says_what_the_pages_of_machines_do():
    status, thesis, koan = ((ROOT / "docs" / name).read_text() for name in (
        "status.md", "machine-thesis.md", "machine-koan.md"))
    rows = {row[0]: row[1:] for row in (line.strip("| ").split(" | ") for line in status.splitlines()
                                        if line.startswith("| ")) if len(row) == 3}
    here, _ = rows["Shen 1993, thesis"]
    # Pages name tables and figures as "tables 6.2 and 6.3"; the schedule's page has the two of its benchmark.
    assert numbers(here, "table") == numbers(thesis, "table") | {"6.5", "6.6"}
    assert numbers(here, "figure") == numbers(thesis, "figure")
    found, = re.findall(r"table 3 within 1 %: the simulator is up to ([\d.]+) % off", rows["KOAN 1991"][1])
    assert found == max(re.findall(r"^\| table 3, [^:|]*: largest error \| <= 1.0 % \| ([\d.]+) %", koan,
                                   re.MULTILINE), key=float)


def numbers(text, kind):
    """Those of the tables, or figures, of chapter 6 that a text names."""
    return set(re.findall(r"6\.\d+", " ".join(re.findall(rf"\b{kind}s? ((?:6\.\d+(?:, | and )?)+)", text))))


# LUTs, registers, DSP blocks and block RAMs of an ECP5-85.
DEVICE = 83640, 83640, 156, 208


def test_shares_follow_from_the_five_numbers():
    readme = (ROOT / "README.md").read_text()
    cycles, = (int(number.replace(",", "")) for number in re.findall(
        r"^\| \*\*([\d,]+)\*\* \| cycles", readme, re.MULTILINE))
    assert f" a hemisphere of 1,024 rays in the Cornell box: {1024 / cycles:.2f} rays per cycle" in readme
    cycles, rate = re.search(r" 16,384 rays in ([\d,]+) cycles<!--.*?-->, ([\d.]+) rays per cycle",
                             " ".join(readme.split())).groups()
    assert rate == f"{16384 / int(cycles.replace(',', '')):.1f}"


def test_the_machine_of_the_readme_is_the_last_one_routed():
    """`radiosity figures` writes its clock; a cluster is that of the page."""
    last = last_records(read_history())
    machine = last["ecp5", "board", machine_parameters("board", ()), *MACHINE]
    cluster = last["ecp5", "small", machine_parameters("small", ()), "cluster", "Cluster"]
    text = (ROOT / "README.md").read_text()
    assert (f"| **{machine.lut:,}** | LUT and {machine.dsp} DSP blocks, {100 * machine.lut / DEVICE[0]:.0f} % of the "
            "LUTs of an ECP5-85, for a whole machine") in text
    assert f" on speed grade 6, commit {machine.commit[:7]};" in text
    assert f" of preset `small` alone takes {cluster.lut:,} LUT |" in text


def test_area_of_a_cluster():
    """The rows of the page are the records of its commands at one commit."""
    page, last = ROOT / "docs" / "area.md", last_records(read_history())
    assignments = [[word for option, word in pairwise(command.words) if option == "-P"]
                   for command in commands_of(page) if command.words[:5] == ("python", "-m", "hw", "report", "cluster")]
    assert len(assignments) == 2
    records = [last["ecp5", "small", " ".join(given), "cluster", "Cluster"] for given in assignments]
    expected = [[one.lut, one.ff, one.dsp, one.bram] for one in records]
    commit, = {one.commit[:7] for one in records}
    assert f"Synthesised (pyosys 0.70) at commit {commit}, not placed:" in page.read_text()
    rows = re.findall(r"^\|.*\|(?: [\d,]+ \(\d+ %\) \|){4}$", page.read_text(), re.MULTILINE)
    quoted = [[int(number.replace(",", "")) for number in re.findall(r"([\d,]+) \(", row)] for row in rows]
    assert quoted == expected
    shares = [[int(share) for share in re.findall(r"(\d+) %", row)] for row in rows]
    assert shares == [[round(100 * count / device) for count, device in zip(row, DEVICE, strict=True)]
                      for row in expected]


def test_a_ray_lane():
    """The units that it repeats, at one commit; u and v are two of them."""
    *units, (_, luts, _, multipliers, _, _) = added_area(2)
    assert len({commit for *_, commit in units}) == 1
    uv = sum(count for unit, count, *_ in units if unit.startswith("`Uv"))
    page = " ".join((ROOT / "docs" / "area.md").read_text().split())
    assert f"u and v [{uv:,} LUTs](#two-ray-lanes)" in page
    assert f"The lane adds {luts:,} LUTs and {multipliers} DSP blocks" in page
    assert f"without u and v {luts - uv:,} LUTs." in page
