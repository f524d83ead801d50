"""The thesis' comparison of networks (tables 6.2 and 6.3), simulated, with tests per patch (tables 6.8 and 6.9).

``radiosity bench thesis_networks`` simulates one frustum in `lobby` and in `room1627` on 8 and 16 clusters in each of
the thesis' networks, on three machines: ours, ours with the thesis' local request of 10 intersection times, and the
thesis' with that request. It writes out/bench/thesis_networks.md: ratios of times beside the thesis', each with a
grade. Nothing is set for a scene.
"""

from itertools import chain

import numpy as np

from benchmarks.grades import grade
from benchmarks.machine_cuts import cut_config, prepare_cut, simulate_cut, thesis_config
from benchmarks.report import benchmark, provenance, table, write_report
from radiosity.cli.console import console

__all__ = ["EDRC", "RATIOS", "THESIS", "ratios_of", "spread_of"]

# Times by scene, clusters and network.
THESIS = {
    ("lobby", 8): {"illiac": 7390.2, "torus": 7390.2, "ring": 7444.1},
    ("lobby", 16): {"illiac": 4425.7, "torus": 4425.7, "hypercube": 4425.7, "ring": 6178.2},
    ("room1627", 8): {"illiac": 10937.2, "torus": 10937.2, "ring": 11083.6},
    ("room1627", 16): {"illiac": 16938.0, "torus": 14201.2, "hypercube": 15661.4, "ring": 26163.4}}
# Tests per patch of each cluster, by scene and clusters.
EDRC = {
    ("lobby", 8): (125.32, 51.7, 42.2, 27.34, 47.69, 20.8, 135.24, 72.94),
    ("lobby", 16): (85.78, 60.16, 33.62, 59.16, 20.59, 24.21, 29.96, 26.83, 11.69, 36.36, 72.18, 75.12, 9.42, 20.13,
                    12.5, 20.82),
    ("room1627", 8): (9.32, 19.64, 20.18, 7.93, 9.39, 22.36, 9.72, 26.06),
    ("room1627", 16): (26.46, 8.72, 7.06, 11.13, 6.13, 12.35, 13.9, 5.84, 8.88, 14.14, 4.7, 3.35, 3.84, 4.97, 4.31,
                       5.01)}
_SCENES = tuple(dict.fromkeys(scene for scene, _ in THESIS))
# By name: a network and its clusters, divided by another network and its clusters.
RATIOS = {
    "torus, 8 : 16": (("torus", 8), ("torus", 16)), "ring, 8 : 16": (("ring", 8), ("ring", 16)),
    "ring : torus, 8": (("ring", 8), ("torus", 8)), "ring : torus, 16": (("ring", 16), ("torus", 16)),
    "Illiac : torus, 16": (("illiac", 16), ("torus", 16)), "hypercube : torus, 16": (("hypercube", 16), ("torus", 16))}
_CELL, _NETWORKS = 0.5, ("illiac", "torus", "hypercube", "ring")
# Machines: a configuration, and the cycles in which a memory has a patch read.
_MACHINES = {"ours": (cut_config, None), "ours, local request 10": (cut_config, 10), "the thesis'": (thesis_config, 10)}


def ratios_of(times: dict, scene: str) -> dict[str, float]:
    """The ratios of a scene, from times as in `THESIS`."""
    return {name: times[scene, above][network] / times[scene, below][other]
            for name, ((network, above), (other, below)) in RATIOS.items()}


def spread_of(edrc: dict, scene: str) -> dict[str, float]:
    """Ratios of tests per patch in a scene, from values as in `EDRC`."""
    few, many = np.asarray(edrc[scene, 8]), np.asarray(edrc[scene, 16])
    return {"mean, 8 : 16": few.mean() / many.mean(), "most : least, 8": few.max() / few.min(),
            "most : least, 16": many.max() / many.min()}


def _simulated(scenes):
    """Simulated cycles by machine, then as in `THESIS`; and tests per patch of the thesis' machine, as in `EDRC`."""
    found, edrc = {name: {} for name in _MACHINES}, {}
    for (scene, clusters), networks in THESIS.items():
        if scene not in scenes:
            continue
        for name, (config, local) in _MACHINES.items():
            prepared = prepare_cut(scene, config(clusters), cell=_CELL)
            found[name][scene, clusters] = {network: max(one.cycles for one in simulate_cut(
                prepared, config(clusters, network), local=local)) for network in networks}
            console().note(f"{scene}, {clusters} clusters, {name}: {found[name][scene, clusters]}")
        edrc[scene, clusters] = prepared.edrc
    return found, edrc


@benchmark("thesis_networks", _SCENES, only=True)
def main(scenes) -> None:
    """Simulate the thesis' networks; SCENES default to lobby and room1627."""
    scenes = tuple(dict.fromkeys(scenes))
    found, edrc = _simulated(scenes)
    cycles = [[f"`{scene}`", clusters, name, *(f"{each[one]:,}" if one in each else "" for one in _NETWORKS)]
              for name, times in found.items() for (scene, clusters), each in times.items()]
    rows = []
    for scene in scenes:
        thesis, simulated = ratios_of(THESIS, scene), {name: ratios_of(times, scene) for name, times in found.items()}
        for ratio, expected in thesis.items():
            rows.append([f"`{scene}`", ratio, f"{expected:.2f}", *(
                text for each in simulated.values() for text in (f"{each[ratio]:.2f}", grade(each[ratio], expected)))])
    coherence, spreads = [], []
    for scene in scenes:
        for clusters in (8, 16):
            coherence.append([f"`{scene}`", clusters, *(f"{number:.1f}" for values in (EDRC, edrc) for number in (
                np.min(values[scene, clusters]), np.mean(values[scene, clusters]), np.max(values[scene, clusters])))])
        thesis, simulated = spread_of(EDRC, scene), spread_of(edrc, scene)
        spreads += [[f"`{scene}`", ratio, f"{expected:.2f}", f"{simulated[ratio]:.2f}",
                     grade(simulated[ratio], expected)] for ratio, expected in thesis.items()]
    write_report(
        "The thesis' networks, simulated",
        f"{provenance('numpy')}; ours: preset paper without a patch store, 1024 patches in each cluster; the thesis': "
        f"preset thesis; 256 x 64 rays from point 5 of the ceiling, cell {_CELL:g}, sections and resident sets by a "
        "sparse casting from point 0.",
        table(["scene", "clusters", "machine", "Illiac", "torus", "hypercube", "ring"], cycles),
        table(["scene", "ratio of times", "thesis", *chain.from_iterable(
            (name, f"grade of {name}") for name in _MACHINES)], rows),
        "Tests per patch (EDRC) of each cluster:",
        table(["scene", "clusters", *(f"{one}, {of}" for of in ("thesis", "simulated") for one in (
            "least", "mean", "most"))], coherence),
        table(["scene", "ratio of tests per patch", "thesis", "simulated", "grade"], spreads))
