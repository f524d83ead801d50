"""How many reads have to be under way to hide main memory's latency.

``python -m tb.bench.main_memory`` reads without a stall through the main memory port, in a simulator, and writes
out/bench/main_memory.md: beats per cycle against the memory's latency and the bursts that may be under way, beside
what these can give at most.
"""

import json
from pathlib import Path

import click

from hw.memsys.main_memory_port import MainMemoryPort
from tb.bench.report import provenance, write_report
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, simulate
from tb.memsys import test_main_memory_port

LATENCIES = (1, 5, 10, 20, 50, 100, 200)
OUTSTANDING = (1, 2, 4, 8, 16)
# A burst is 64 bytes: a patch.
BURST_BEATS = 8
BEATS = 512


def rates(outstanding: int, simulator: str) -> dict[int, float]:
    """Beats per cycle by the memory's latency."""
    changes = {**test_main_memory_port.SMALL, "memory.outstanding": outstanding, "memory.burst_beats": BURST_BEATS,
               "memory.timeout_bits": 12}
    path = (BUILD / "vectors" / f"main-memory-{outstanding}.json").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    component = MainMemoryPort(config=config_of(changes), tag=test_main_memory_port.TAG)
    simulate(component, test_main_memory_port.MODULE, ("rates",), simulator=simulator,
             name=f"main-memory-{outstanding}", changes=changes, memory_latencies=LATENCIES, beats=BEATS,
             rates=str(path))
    return {int(latency): rate for latency, rate in json.loads(path.read_text()).items()}


def bound(outstanding: int, latency: int) -> float:
    """Beats per cycle if a slot is used again as soon as its burst has gone out.

    A burst takes its slot until memory answers, while its beats come, for two cycles, and while they go.
    """
    return min(1.0, outstanding * BURST_BEATS / (latency + 2 * BURST_BEATS + 2))


@click.command()
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="out/bench/main_memory.md")
@click.option("--simulator", type=click.Choice(["verilator", "icarus"]), default="icarus")
def main(output: Path, simulator: str) -> None:
    """Write the table."""
    found = {outstanding: rates(outstanding, simulator) for outstanding in OUTSTANDING}
    head = "| bursts under way | " + " | ".join(f"{latency} cycles" for latency in LATENCIES) + " |"
    lines = [
        "# Main memory: beats per cycle", "",
        f"{provenance('amaranth', 'cocotb')}; beats of 64 bits, bursts of {BURST_BEATS} of them (a patch), reads "
        "without a stall from a memory that gives a beat per cycle after its latency.", "",
        head, "|---" * (len(LATENCIES) + 1) + "|",
        *(f"| {outstanding} | " + " | ".join(f"{by_latency[latency]:.3f}" for latency in LATENCIES) + " |"
          for outstanding, by_latency in found.items()), "",
        "What the slots give: a burst has one until memory answers, while its beats come, for two cycles, and while "
        "they go.", "",
        head, "|---" * (len(LATENCIES) + 1) + "|",
        *(f"| {outstanding} | " + " | ".join(f"{bound(outstanding, latency):.3f}" for latency in LATENCIES) + " |"
          for outstanding in OUTSTANDING), ""]
    click.echo("\n".join(lines[4:6 + len(OUTSTANDING)]))
    write_report(output, lines)


if __name__ == "__main__":
    main()
