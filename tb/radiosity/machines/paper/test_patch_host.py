"""The host answers requests before it pushes."""

from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.patch_host import PatchHost
from tb.radiosity.machines.paper.timings import TIMING


class Bench:
    """A host of four clusters, whose deliveries are noted."""

    def __init__(self, levels=2):
        self.agenda, self.accepted, self.answered = Agenda(), [], []
        self.host = PatchHost(
            self.agenda, TIMING, levels=levels,
            accept=lambda cluster, patch: self.accepted.append((self.agenda.now, cluster, patch)),
            answer=lambda cluster, patch: self.answered.append((self.agenda.now, cluster, patch)))


def test_a_request_ascends_and_its_patch_descends():
    bench = Bench()
    bench.agenda.at(5, bench.host.request, 3, 8)
    bench.agenda.run()
    # Two switches up, main memory, the words, two switches down.
    assert bench.answered == [(5 + 6 + 10 + 6 + 6, 3, 8)]
    assert (bench.host.replies, bench.host.busy, bench.host.link_words) == (1, 6, 18)


def test_requests_share_the_links_of_switches():
    """Clusters 2 and 3 meet at the link above their switch, and all at main memory."""
    bench = Bench()
    for cluster in (2, 3):
        bench.agenda.at(0, bench.host.request, cluster, cluster)
    bench.agenda.run()
    assert [time for time, _, _ in bench.answered] == [28, 34]
    bench = Bench()
    for patch in range(3):
        bench.agenda.at(0, bench.host.request, 2, patch)
    bench.agenda.run()
    assert [time for time, _, _ in bench.answered] == [28, 34, 40]


def test_a_pushed_patch_arrives_everywhere_at_once():
    bench = Bench()
    bench.host.push(9, [0, 1, 3], 6)
    bench.agenda.run()
    assert bench.accepted == [(12, 0, 9), (12, 1, 9), (12, 3, 9)]
    assert (bench.host.pushed, bench.host.busy, bench.host.link_words) == (1, 6, 36)


def test_a_reply_precedes_patches_to_push():
    bench = Bench(levels=0)
    for patch in range(4):
        bench.host.push(patch, [0], 1)
    bench.agenda.at(0, bench.host.request, 0, 7)
    bench.agenda.run()
    # The request is at main memory in cycle 10, while the second patch leaves.
    assert [(time, patch) for time, _, patch in bench.accepted] == [(6, 0), (12, 1), (24, 2), (30, 3)]
    assert bench.answered == [(18, 0, 7)]


def test_tags_are_announced_before_patches():
    bench = Bench()
    assert bench.host.announce([3, 4, 5]) == 3 + 6
    bench.host.push(9, [0], 3)
    bench.agenda.run()
    assert bench.accepted == [(3 + 6 + 6, 0, 9)]
    assert (bench.host.busy, bench.host.link_words) == (9, 12 + 18)


def test_a_patch_to_more_clusters_takes_the_root_as_long():
    """That is what pushes a patch on both sides once, where clusters would request it one by one."""
    bench = Bench()
    bench.host.push(9, [0, 1, 2, 3], 7)
    bench.host.push(8, [2], 3)
    bench.agenda.run()
    assert [time for time, _, _ in bench.accepted] == [12] * 4 + [18]
    assert (bench.host.busy, bench.host.link_words) == (12, 6 * 10)
