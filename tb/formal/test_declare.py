import pytest
from amaranth.hdl import Assert, Cover, Signal

from hw.lib.queue import Queue
from tb.formal import prove as module
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare
from tb.formal.prove import FOLDER, prove

pytestmark = pytest.mark.sim


def counts(m, bench, dut, most):
    """A counter that a free signal stops."""
    count = Signal(4)
    m.d.sync += count.eq(count + bench.free(1, "counts"))
    m.d.comb += [Assert(count != most, "most"), Assert(count[:2] <= 3, "same"), Cover(count == 3, "three")]


def make(most=9):
    return Bench(counts, Queue(1, depth=1), most=most)


def cases_of(**given):
    """What a declaration runs, by name."""
    given = {"cycles": 8, "controls": {"stops early": Control("most", most=2)}} | given
    return {case.id: case.values[0] for case in declare(make, **given).pytestmark[0].args[1]}


def test_a_declaration_has_claim_cover_and_control():
    found = cases_of(claims=[Claim(), Claim(most=8, cycles=6)])
    assert list(found) == ["holds", "holds most=8 cycles=6", "reaches", "reaches most=8", "fails stops early"]
    for name in "holds", "reaches", "fails stops early":
        found[name]()


@pytest.mark.parametrize(("missing", "given"), [("claim", {"claims": []}), ("control", {"controls": {}})])
def test_a_declaration_without_a_part_is_refused(missing, given):
    with pytest.raises(ValueError, match=rf"^Declaration must have a {missing}$"):
        cases_of(**given)


@pytest.mark.parametrize("engine", [None, "abc bmc3"])
def test_a_cover_must_be_reached_within_the_claims_cycles(engine):
    cases_of(claims=[Claim(cycles=4)], engine=engine)["reaches"]()
    with pytest.raises(AssertionError):
        cases_of(claims=[Claim(), Claim(cycles=3)], engine=engine)["reaches"]()


def test_a_control_must_break_the_assertion_that_it_names():
    with pytest.raises(AssertionError):
        cases_of(controls={"stops early": Control("same", most=2)})["fails stops early"]()
    with pytest.raises(ValueError, match=r"^Bench must assert something of name 'other'$"):
        cases_of(controls={"stops early": Control("other", most=2)})["fails stops early"]()


def test_a_bench_without_a_cover_is_refused():
    def asserts(m, bench, dut):
        m.d.comb += Assert(dut.level <= 1, "level")

    with pytest.raises(ValueError, match=r"^Bench must cover something$"):
        prove(Bench(asserts, Queue(1, depth=1)), mode="cover", depth=2)


def test_a_proof_that_runs_is_not_removed(monkeypatch):
    """Another process that removes old proofs spares it."""
    run = module.subprocess.run

    def prune_and_run(*given, **options):
        module.keep_newest(FOLDER, most=0)
        return run(*given, **options)

    monkeypatch.setattr(module.subprocess, "run", prune_and_run)
    assert prove(make(most=13), mode="bmc", depth=2)
