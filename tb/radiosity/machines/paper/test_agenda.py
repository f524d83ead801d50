"""The agenda runs actions by time, then by entry."""

import pytest

from radiosity.machines.paper.agenda import Agenda


def test_actions_run_by_time_and_then_by_entry():
    agenda, seen = Agenda(), []

    def note(name):
        seen.append((agenda.now, name))
        if name == "first":
            agenda.at(3, note, "later")

    for time, name in ((3, "second"), (1, "first"), (3, "third")):
        agenda.at(time, note, name)
    assert agenda.run() == 3
    assert seen == [(1, "first"), (3, "second"), (3, "third"), (3, "later")]


def test_the_past_is_closed():
    agenda = Agenda()
    agenda.at(5, lambda: agenda.at(4, print))
    with pytest.raises(ValueError, match=r"^Time must be at least 5, not 4$"):
        agenda.run()
