"""Kurc's tables of merged pictures (4.1 to 4.3) and his figures of split volumes (6.16 to 6.21), simulated.

``radiosity bench merge`` simulates scenes of teapots with the source's numbers of pixels, and blunt fins with its
number of triangles, each with 20 seeds. It writes out/bench/merge.md: times and ratios beside the source's, and its
statements, each with a grade and the percentile of the seeds at which the source's value lies. Nothing is set for a
scene but its numbers of pixels.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.grades import grade, grade_of, signed
from benchmarks.report import benchmark, provenance, table, write_report
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.teapot import CONTROL_POINTS
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.tessellate import bezier
from radiosity.cli.console import console
from radiosity.machines.merge.merge_run import MergeRun, MergeScheme, simulate_merge
from radiosity.machines.merge.screen_split import SPLITTERS
from radiosity.machines.merge.screen_triangles import ScreenTriangles, project_scene
from radiosity.machines.merge.screen_volume import drawn_direction, view_volume
from radiosity.machines.merge.span_lists import pixel_counts, span_lists
from radiosity.machines.merge.tetrahedra import blunt_fin
from radiosity.machines.merge.volume_run import simulate_volume
from radiosity.machines.merge.winning_pixels import pixels_of_spans

__all__ = ["FULL", "MERGES", "POTS", "Pots", "matched_pots", "percentile", "pots_of"]

_WIDTH, _NODES, _CUTS, _SEEDS = 400, 16, 8, 20
# Steps by which scenes are matched: halvings of the range of spreads, and scales for each.
_HALVINGS, _SCALINGS = 7, 5
_SIZES = (400, 640)


@dataclass(frozen=True, kw_only=True)
class Pots:
    """A scene of table 4.1.

    Parameters
    ----------
    count
        Teapots.
    generated, winning
        Pixels by size of the screen, see `_SIZES`: those that all triangles generate, and those of the picture.
    """

    count: int
    generated: tuple[int, int]
    winning: tuple[int, int]


POTS = {
    "1 POT": Pots(count=1, generated=(59091, 137043), winning=(43247, 110515)),
    "2 POT": Pots(count=2, generated=(66802, 151881), winning=(37084, 94840)),
    "4 POT_1": Pots(count=4, generated=(71578, 146468), winning=(26328, 66727)),
    "4 POT_2": Pots(count=4, generated=(81735, 171480), winning=(35629, 90692)),
    "8 POT_1": Pots(count=8, generated=(154187, 324464), winning=(52258, 133617)),
    "8 POT_2": Pots(count=8, generated=(99589, 201829), winning=(36043, 91729))}
# Milliseconds of the merge of table 4.2 by nodes and scene: pairs by recursion, and exchanged z-buffers.
FULL = {
    (16, "1 POT"): (348, 2015), (16, "2 POT"): (341, 1940), (16, "4 POT_1"): (323, 1930), (16, "4 POT_2"): (408, 1958),
    (16, "8 POT_1"): (684, 2043), (16, "8 POT_2"): (451, 1958), (8, "1 POT"): (468, 1941), (8, "2 POT"): (475, 1882),
    (8, "4 POT_1"): (419, 1798), (8, "4 POT_2"): (545, 1881)}
_SCHEMES = {"AAPC-HBP": MergeScheme(name="aapc", division="packed"),
            "AAPC-RS": MergeScheme(name="aapc", division="recursive"),
            "PAIR-RS": MergeScheme(name="pair", division="recursive")}
# Milliseconds of table 4.3 by size, nodes and scene: local pixels and merge of each scheme above.
MERGES = {
    (400, 16, "4 POT_1"): ((550, 181), (524, 218), (520, 323)),
    (400, 16, "8 POT_1"): ((1126, 302), (1083, 376), (1079, 684)),
    (400, 8, "4 POT_1"): ((1031, 250), (992, 291), (989, 419)),
    (400, 8, "8 POT_1"): ((2098, 464), (2034, 543), (2030, 861)),
    (640, 16, "4 POT_1"): ((1060, 333), (1016, 418), (1011, 702)),
    (640, 16, "8 POT_1"): ((2238, 611), (2170, 794), (2165, 1502)),
    (640, 8, "4 POT_1"): ((2013, 540), (1951, 636), (1947, 936)),
    (640, 8, "8 POT_1"): ((4250, 1050), (4146, 1242), (4142, 1957))}
# Speedups of 16 nodes: by triangles alone and with spans and pixels, and the latter with the split; the least gain.
_ALONE, _WEIGHTED, _WITH_SPLIT, _GAIN = 5.24, 11.44, 9.40, 1.8
# Ratios that must be met: of pairs over each to all, and of exchanged z-buffers over pairs on 16 nodes.
_PAIR_BAND, _FULL_LEAST = (1.4, 3.0), 2.5


def pots_of(count: int, spread: float, seed: int) -> tuple[ScreenTriangles, np.ndarray]:
    """Teapots turned anyhow, anywhere on a disc, seen from above at a drawn height; the screen has a width of 1.

    Parameters
    ----------
    count
        Teapots.
    spread
        Radius of the disc, in widths of a teapot.
    seed
        Draws places, turns and the direction of view.
    """
    rng = np.random.default_rng(seed)
    patches, builder = bezier(CONTROL_POINTS, cuts=_CUTS), SceneBuilder("pots")
    glaze = Material(name="glaze", diffuse=(0.62, 0.58, 0.5))
    for _ in range(count):
        turn, around, radius = rng.random(3) * (2 * np.pi, 2 * np.pi, 1)
        spun = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        middle = 6 * spread * np.sqrt(radius) * np.array([np.cos(around), np.sin(around), 0])
        builder.add(patches @ spun + middle, glaze)
    height = rng.uniform(0.25, 0.7)
    eye = 60 * np.array([0, -np.sqrt(1 - height**2), height])
    camera = Camera(eye=tuple(eye), target=(0, 0, 1.2), fov=30)
    triangles, number = project_scene(builder.build(), camera, 1, 1)
    return triangles, number


def _scaled(triangles, scale, size):
    """The triangles on a screen of size x size pixels."""
    return triangles._replace(corners=triangles.corners * (scale * size, scale * size, 1) + (size / 2, size / 2, 0))


def _counts(triangles, size):
    """Pixels generated, and those of the picture."""
    spans = span_lists(triangles, np.zeros(len(triangles.corners)), size, size)
    return int(pixel_counts(spans, 1)[0]), len(pixels_of_spans(spans, 1, size).location)


def matched_pots(pots: Pots, seed: int) -> tuple[ScreenTriangles, np.ndarray, float]:
    """Pots with the source's pixels at 400 x 400: triangles for a screen of width 1, their numbers, and their scale.

    The scale gives the pixels of the picture, and the spread of more pots than one the pixels generated, as far as it
    can.

    Parameters
    ----------
    pots
        The scene.
    seed
        See `pots_of`.
    """
    low, high = 0.02, 4.0
    for _ in range(_HALVINGS if pots.count > 1 else 1):
        spread = np.sqrt(low * high)
        triangles, number = pots_of(pots.count, spread, seed)
        scale, generated = _fitted(triangles, pots.winning[0])
        # Pots that are farther apart cover each other less.
        low, high = (spread, high) if generated > pots.generated[0] else (low, spread)
    return triangles, number, scale


def _fitted(triangles, winning):
    """The scale by which so many pixels win, and the pixels generated: areas grow with the square of a scale."""
    scale = 1.0
    for _ in range(_SCALINGS):
        generated, found = _counts(_scaled(triangles, scale, _WIDTH), _WIDTH)
        # Pots may leave the screen if a step is too large.
        scale *= np.clip(np.sqrt(winning / max(found, 1)), 0.5, 2) if found else 0.5
    return scale, generated


def percentile(value: float, values: list[float]) -> int:
    """The percentage of the values that are below one."""
    return round(100 * float(np.mean(np.asarray(values) < value)))


def _merged(matched, scheme, nodes, size) -> MergeRun:
    triangles, number, scale = matched
    return simulate_merge(_scaled(triangles, scale, size), number, scheme, nodes=nodes, width=size, height=size)


def _beside(source, values, *, digits=0) -> list[str]:
    """Source, median, range and percentile."""
    return [f"{source:.{digits}f}", f"{np.median(values):.{digits}f}",
            f"{min(values):.{digits}f} to {max(values):.{digits}f}", f"{percentile(source, values)} %"]


def _merge_tables() -> list[list[str]]:
    """Tables of scenes, of exchanged z-buffers, of merges, and of statements."""
    matched = {name: [matched_pots(pots, seed) for seed in range(_SEEDS)] for name, pots in POTS.items()}
    console().note("scenes are matched")
    scenes = []
    for name, pots in POTS.items():
        for at, size in enumerate(_SIZES):
            found = np.array([_counts(_scaled(one[0], one[2], size), size) for one in matched[name]])
            scenes.append([name, size, *_beside(pots.generated[at], found[:, 0].tolist()),
                           *_beside(pots.winning[at], found[:, 1].tolist())])
    rows, ratios, seconds = [], [], {}

    def merge_ms(name, scheme, nodes, size):
        key = name, scheme, nodes, size
        if key not in seconds:
            runs = [_merged(one, scheme, nodes, size).phases for one in matched[name]]
            seconds[key] = [[1000 * run[phase] for run in runs] for phase in ("local_pixels", "merge")]
        return seconds[key]

    full = MergeScheme(name="pair", division="equal", is_full=True)
    for (nodes, name), (pair, exchanged) in FULL.items():
        own = [merge_ms(name, scheme, nodes, _WIDTH)[1] for scheme in (_SCHEMES["PAIR-RS"], full)]
        cells = _WIDTH * _WIDTH * (nodes - 1) / nodes
        rows.append([name, nodes, f"{1000 * exchanged / cells:.2f}", f"{exchanged}", f"{np.median(own[1]):.0f}",
                     signed(np.median(own[1]) / exchanged - 1), *_beside(pair, own[0]),
                     grade(np.median(own[0]), pair)])
        ratio = (np.array(own[1]) / own[0]).tolist()
        is_enough = nodes != _NODES or np.median(ratio) >= _FULL_LEAST
        ratios.append(["exchanged z-buffers : PAIR-RS", name, nodes, _WIDTH,
                       *_beside(exchanged / pair, ratio, digits=2),
                       grade(np.median(ratio), exchanged / pair) if is_enough else "not reproduced"])
        console().note(f"table 4.2: {name}, {nodes} nodes")
    merges = []
    for (size, nodes, name), source in MERGES.items():
        own = {}
        for (label, scheme), both in zip(_SCHEMES.items(), source, strict=True):
            own[label] = merge_ms(name, scheme, nodes, size)
            cells = [cell for value, values in zip(both, own[label], strict=True)
                     for cell in (f"{value}", f"{np.median(values):.0f}")]
            merges.append([name, size, nodes, label, *cells, f"{percentile(both[1], own[label][1])} %",
                           grade(np.median(own[label][1]), both[1])])
        for above, below in (("PAIR-RS", "AAPC-HBP"), ("AAPC-RS", "AAPC-HBP")):
            at = list(_SCHEMES).index(above)
            ratio = (np.array(own[above][1]) / own[below][1]).tolist()
            expected = source[at][1] / source[0][1]
            is_within = above != "PAIR-RS" or _PAIR_BAND[0] <= np.median(ratio) <= _PAIR_BAND[1]
            ratios.append([f"{above} : {below}", name, nodes, size, *_beside(expected, ratio, digits=2),
                           grade(np.median(ratio), expected) if is_within else "not reproduced"])
        console().note(f"table 4.3: {name}, {size}, {nodes} nodes")
    beside = ["source", "median", "range", "percentile of the source"]
    return [table(["scene", "size", *(f"{which}, {one}" for which in ("generated", "winning") for one in beside)],
                  scenes),
            table(["scene", "nodes", "source's us a cell", "exchanged z-buffers", "simulated", "error",
                   *(f"PAIR-RS, {one}" for one in beside), "grade of PAIR-RS"], rows),
            table(["scene", "size", "nodes", "scheme", "local", "local, simulated", "merge", "merge, simulated",
                   "percentile of the source", "grade of merge"], merges),
            table(["ratio of merges", "scene", "nodes", "size", *beside, "grade"], ratios)]


def _volume_tables() -> list[list[str]]:
    """Tables of splitters, and of statements."""
    found = {(splitter, is_weighted): [] for splitter in SPLITTERS for is_weighted in (False, True)}
    for seed in range(_SEEDS):
        seen, alone = view_volume(blunt_fin(seed=seed), drawn_direction(seed), 512, 512), None
        for (splitter, is_weighted), each in found.items():
            run = simulate_volume(seen, splitter, nodes=_NODES, is_weighted=is_weighted, is_sampled=False, alone=alone)
            alone = run.alone
            report = run.report()
            each.append((run.balance, 100 * run.growth, run.speedup, report["speedup"], report["splitting_seconds"]))
        console().note(f"volume of seed {seed}")
    numbers = {key: np.array(each).T for key, each in found.items()}
    rows = [[splitter.upper(), *(f"{np.median(numbers[splitter, False][at]):.{digits}f}" for at, digits in (
                (0, 3), (1, 1), (2, 2))), *(f"{np.median(numbers[splitter, True][at]):.{digits}f}"
                                            for at, digits in ((2, 2), (3, 2), (4, 3)))] for splitter in SPLITTERS]
    first = {name: sum(int(each[:, seed].argmin() if is_least else each[:, seed].argmax()) == list(SPLITTERS).index(who)
                       for seed in range(_SEEDS))
             for name, who, is_least, each in (
                 ("RRS is balanced best", "rrs", True, _stacked(numbers, False, 0)),
                 ("RRS has the fewest shared triangles", "rrs", True, _stacked(numbers, False, 1)),
                 ("HS draws fastest", "hs", False, _stacked(numbers, True, 2)),
                 ("HS is fastest with the split", "hs", False, _stacked(numbers, True, 3)),
                 ("HS splits fastest", "hs", True, _stacked(numbers, True, 4)))}
    statements = [[name, "first of six", f"{count} of {_SEEDS}", "", "",
                   grade_of(2 * count > _SEEDS, count > 0)]
                  for name, count in first.items()]
    best = [_stacked(numbers, is_weighted, at).max(axis=0) for is_weighted, at in ((False, 2), (True, 2), (True, 3))]
    for name, source, values in (("best speedup by triangles alone", _ALONE, best[0]),
                                 ("best speedup by triangles, spans and pixels", _WEIGHTED, best[1]),
                                 ("the same with the split", _WITH_SPLIT, best[2]),
                                 ("gain by spans and pixels", _WEIGHTED / _ALONE, best[1] / best[0])):
        is_low = name.startswith("gain") and np.median(values) < _GAIN
        statements.append([name, *_beside(source, values.tolist(), digits=2),
                           "not reproduced" if is_low else grade(np.median(values), source)])
    return [table(["splitter", "most : average", "growth, %", "speedup by triangles", "speedup with spans and pixels",
                   "the same with the split", "split, s"], rows),
            table(["statement", "source", "simulated", "range", "percentile of the source", "grade"], statements)]


def _stacked(numbers, is_weighted, at):
    """Six x seeds."""
    return np.stack([numbers[splitter, is_weighted][at] for splitter in SPLITTERS])


@benchmark("merge")
def main() -> None:
    """Simulate tables 4.1 to 4.3 and figures 6.16 to 6.21 of Kurc's thesis."""
    write_report(
        "Merged pictures and split volumes, simulated",
        f"{provenance('numpy')}; {_SEEDS} seeds; medians, ranges and percentiles are over these.",
        *_merge_tables(), *_volume_tables())
