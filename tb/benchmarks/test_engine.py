"""The table of the machine's cycles."""

from benchmarks.engine import STALLS, rows_of


def report(cycles, bound):
    each = {name: number for number, name in enumerate(STALLS)} | {"efficiency": 0.25}
    return {"cell": 0.25, "cast_cycles": cycles, "cold": 2 * cycles, "first_cycles": 3 * cycles, "load_cycles": 77,
            "of_bound": bound / cycles, "efficiency": 0.5, "tests_per_ray": 1.5, "edrc": 20.0,
            "bound": {"traversal": bound, "intersection": 10, "patches": 4},
            "sources": {"own": 5, "kept": 9, "remote": 6, "hits": 7, "misses": 8},
            "each": [each, each | {STALLS[0]: 99}]}


def test_rows_compare_with_the_first_number_of_clusters():
    cycles, stalls = rows_of("lobby", {1: report(1000, 800), 4: report(400, 200)})
    assert cycles[0][13:15] == ["1.00", "1.00"]
    assert cycles[1][:7] == ["lobby", 4, "0.25", 1200, 77, 800, 400]
    assert cycles[1][13:15] == ["2.50", "4.00"]
    assert cycles[0][-5:] == [5, 9, 6, 7, 8]
    assert len(cycles[0]) == 22
    assert stalls[1][3:5] == [99, 1]
