"""A bar on terminals of any size."""

import fcntl
import io
import os
import pty
import select
import struct
import termios

import pytest

from golden.progress_bar import progress_bar


@pytest.mark.parametrize("size", [(0, 0), (24, 0), (0, 80), (24, 120)])
def test_a_bar_shows_whatever_size_the_terminal_reports(size, monkeypatch):
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", *size, 0, 0))
    with open(terminal, "w") as screen:
        monkeypatch.setattr("sys.stderr", screen)
        with progress_bar(total=4, desc="cast") as bar:
            bar.update(2)
            bar.refresh()
        shown = b""
        # A terminal hands text over piece by piece.
        while b"cast:  50%" not in shown and select.select([reader], [], [], 5)[0]:
            shown += os.read(reader, 10_000)
    os.close(reader)
    assert b"cast:  50%" in shown


def test_a_file_is_no_terminal(monkeypatch):
    screen = io.StringIO()
    monkeypatch.setattr("sys.stderr", screen)
    with progress_bar(total=4, desc="cast"):
        pass
    assert "cast:   0%" in screen.getvalue()
