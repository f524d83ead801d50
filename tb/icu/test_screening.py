import pytest

from golden.engine.icu.screening import edge_distances, inside
from golden.engine.stimulus import stimulus
from golden.engine.stimulus.icu.edge_planes import planes_of
from hw.icu.screening import Screening
from tb.icu.vectors import assert_all_occur, rows, winding_of
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.runner import SIMULATORS
from tb.radiosity.flow.synthesis.mapped import mapped_text


def drawn(config):
    """Rays and planes, their distances, whether a ray is inside and by which orientation."""
    given = stimulus("icu.intersection", count=400, seed=3, config=config).arrays
    planes = planes_of(given)
    distances = edge_distances(planes, given["ray"], config.numbers)
    return given, distances, *inside(distances, planes)


class TestScreening(Bench):
    component, arguments = Screening, {"tag": 9}

    def vectors(self, config):
        given, distances, held, orientation = drawn(config)
        return Vectors(
            inputs={"i": [{"tag": k, "direction": rows(given["ray"][k]), "planes": rows(given["planes"][k]),
                           "winding": winding_of(given, k)} for k in range(400)]},
            expected={"o": [{"tag": k, "distances": rows(distances[k]), "inside": int(held[k]),
                             "orientation": int(orientation[k])} for k in range(400)]})


@pytest.mark.sim
@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_the_cells_of_its_netlist_do_the_same(simulator, tmp_path):
    TestScreening().simulate(simulator, lambda component: mapped_text(component, tmp_path))


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_the_vectors_hold_every_case(changes):
    given, distances, held, orientation = drawn(config_of(changes))
    split, edges = given["split"] > 0, distances[:, :4]
    first = orientation == given["orientation"][:, 0]
    assert_all_occur({
        "inside": held & ~split, "outside": ~held & ~split, "outside both triangles": ~held & split,
        "in a triangle of the first orientation": held & split & first,
        "in a triangle of the other orientation": held & split & ~first,
        "held by +1": held & (orientation == 1), "held by -1": held & (orientation == -1),
        "at an edge": held & ((edges == 0).sum(axis=1) == 1), "at a vertex": held & ((edges == 0).sum(axis=1) > 1),
        "without orientation": ~given["orientation"].any(axis=1)})
