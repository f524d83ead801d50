"""Proofs as declarations: what holds, what is reached within the same cycles, and the faults that must be noticed."""

from collections.abc import Callable, Sequence

import pytest

from tb.formal.bench import Bench
from tb.formal.prove import prove

__all__ = ["Claim", "Control", "declare"]

_SIM, _NIGHTLY = pytest.mark.sim, pytest.mark.nightly


class Claim:
    """All assertions of a bench hold.

    Parameters
    ----------
    cycles
        The number that is checked, instead of the declaration's.
    unbounded
        All reachable states are checked.
    only
        The name of the one assertion that is claimed.
    nightly
        It takes longer than the hardware's tests may.
    options
        Of the bench.
    """

    def __init__(self, *, cycles: int | None = None, unbounded: bool = False, only: str | None = None,
                 nightly: bool = False, **options):
        self.cycles, self.unbounded, self.only = cycles, unbounded, only
        self.nightly, self.options = nightly, options


class Control:
    """A fault for which one assertion must fail.

    Parameters
    ----------
    breaks
        The name of the assertion.
    faults
        Wrong outputs, see `NegativeControl`; else the fault is in ``options``.
    nightly
        It takes longer than the hardware's tests may.
    options
        Of the bench.
    """

    def __init__(self, breaks: str, faults: dict[str, Callable] | None = None, *, nightly: bool = False, **options):
        self.breaks, self.faults, self.nightly, self.options = breaks, faults, nightly, options


def declare(make: Callable[..., Bench], *, cycles: int, controls: dict[str, Control],
            claims: Sequence[Claim] = (Claim(),), engine: str | None = None, covers_nightly: bool = False) -> Callable:
    """The tests of a property: its claims, that each bench of a claim reaches all its covers, and its controls.

    A cover must be reached within the cycles of the shortest claim about its bench, so that no claim is vacuous;
    and a fault must be noticed within those of a claim that checks the assertion. The hardware's tests check the
    claims, reach the covers of the first bench, and notice the first control's fault; the nightly does all.

    Parameters
    ----------
    make
        The bench, given options.
    cycles
        Depth of the claims that are bounded; where all are unbounded, of the covers and the controls.
    controls
        By fault: the control.
    claims
        What holds.
    engine
        Of all but unbounded claims, see `prove`.
    covers_nightly
        The covers take longer than the hardware's tests may.

    Returns
    -------
    A test, of a module that gives it a name that begins with ``test_``.

    Raises
    ------
    ValueError
        There is no claim, or no control.
    """
    if not claims or not controls:
        raise ValueError(f"Declaration must have a {'control' if claims else 'claim'}")

    def holds(claim):
        if claim.unbounded:
            assert prove(make(**claim.options), only=claim.only)
        else:
            assert prove(make(**claim.options), mode="bmc", depth=claim.cycles or cycles, engine=engine,
                         only=claim.only)

    def reaches(claim, depth):
        assert prove(make(**claim.options), mode="cover", depth=depth, engine=engine)

    def fails(control):
        bench = make(**control.options)
        if control.faults:
            bench.add_faults(control.faults)
        depth = max((one.cycles or cycles for one in claims if not one.unbounded and one.nightly <= control.nightly and
                     one.only in (None, control.breaks)), default=cycles)
        proof = prove(bench, mode="bmc", depth=depth, engine=engine, only=control.breaks)
        assert not proof
        assert proof.trace

    alike: dict[str, list[Claim]] = {}
    for claim in claims:
        alike.setdefault(_words(claim.options), []).append(claim)
    tests = [_case("holds", " ".join(filter(None, [words, one.only, f"cycles={one.cycles}" if one.cycles else ""])),
                   holds, one, tier=_NIGHTLY if one.nightly else _SIM)
             for words, same in alike.items() for one in same]
    tests += [_case("reaches", words, reaches, same[0], min(one.cycles or cycles for one in same),
                    tier=_NIGHTLY if covers_nightly or index > 0 or all(one.nightly for one in same) else _SIM)
              for index, (words, same) in enumerate(alike.items())]
    first = next((name for name, control in controls.items() if not control.nightly), None)
    tests += [_case("fails", name, fails, control, tier=_SIM if name == first else _NIGHTLY)
              for name, control in controls.items()]

    @pytest.mark.parametrize("check", tests)
    def test(check):
        check()

    return test


def _case(kind, words, check, *given, tier):
    def run():
        check(*given)

    return pytest.param(run, id=f"{kind} {words}".strip(), marks=tier)


def _words(options):
    return " ".join(f"{name}={getattr(value, '__name__', value)}" for name, value in options.items())
