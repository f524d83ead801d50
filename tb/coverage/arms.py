"""Which arms of ``If``, ``Switch`` and ``FSM`` a simulation enters, at their lines of Amaranth source."""

from pathlib import Path

from amaranth.hdl import Cat, Format, Fragment, Print, Signal
from amaranth.hdl._ast import Statement, Switch

__all__ = ["MARK", "add_arms"]

# Begins a line that a simulation prints; the arm follows: file, line, and the line of its If, Switch or FSM.
MARK = "@arm "


def add_arms(fragment: Fragment, folder: Path, known: set[str]) -> None:
    """Make a fragment print each arm when it is first entered.

    An arm of a combinational statement is entered in a cycle if it holds at the cycle's end. A transition of an ``FSM``
    is a statement of an arm, so it is made if its arm is entered.

    Parameters
    ----------
    folder
        Arms of files below it are printed.
    known
        Receives all arms, as they are printed behind `MARK`.
    """
    clocked = next((domain for domain in fragment.statements if domain != "comb"), "sync")
    # By arm: it has been printed; and it holds, if a combinational statement says so.
    printed: dict[str, Signal] = {}
    holds: dict[str, Signal] = {}

    def first(arm):
        done, text = printed.setdefault(arm, Signal(name=f"arm_{len(printed)}", reset_less=True)), Print(
            Format(MARK + arm))
        # It becomes part of a statement that no module adds.
        text._MustUse__used = True
        return Switch(done, [(0, [done.eq(1), text], None)])

    def with_marks(statements, domain):
        return Statement.cast([
            Switch(one.test, [(patterns, [*mark(domain, _name(one, where, folder)), *with_marks(inside, domain)], where)
                              for patterns, inside, where in one.cases], src_loc=one.src_loc)
            if isinstance(one, Switch) else one for one in statements])

    def mark(domain, arm):
        if arm is None:
            return []
        known.add(arm)
        if domain != "comb":
            return [first(arm)]
        if arm in printed:
            return []
        return [holds.setdefault(arm, Signal(name=f"arm_holds_{len(holds)}")).eq(1)]

    # An arm with clocked statements is entered when they are executed.
    for domain, statements in sorted(fragment.statements.items(), key=lambda item: item[0] == "comb"):
        fragment.statements[domain] = with_marks(statements, domain)
    if holds:
        seen = Cat(holds.values())
        fragment.add_statements(clocked, [
            Switch(seen[k], [(1, [first(arm)], None)]) for k, arm in enumerate(holds)])


def _name(switch, where, folder):
    """An arm's file and lines, or None if it is not below the folder."""
    if where is None or switch.src_loc is None:
        return None
    path = Path(where[0])
    return f"{path.relative_to(folder.parent)}:{where[1]}:{switch.src_loc[1]}" if path.is_relative_to(folder) else None
