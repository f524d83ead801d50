"""The tutorial of the page on view factors: its blocks of Python run one after the other, then its command."""

import re
import shlex

from click.testing import CliRunner

import radiosity.cli.main
from tb.docs.language import ROOT

PAGE = (ROOT / "docs" / "view-factors.md").read_text()


def test_the_tutorial(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scope = {}
    for block in re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL):
        exec(block, scope)
    printed = capsys.readouterr().out
    assert "(30, 30) True True\n" in printed
    sky, = re.findall(r"sky view factor of the road: (\S+)", printed)
    # Crossed strings, for an endless street.
    assert abs(float(sky) - (2**0.5 - 1)) < 0.015
    (command,) = re.findall(r"^radiosity (exchange .*)$", PAGE, re.MULTILINE)
    result = CliRunner().invoke(radiosity.cli.main.main, shlex.split(command))
    assert result.exit_code == 0, result.output
    assert (tmp_path / "heat.csv").exists()
    assert (tmp_path / "script-f.csv").exists()
