"""The page on Python: its blocks run one after the other."""

import re

import pytest

import radiosity
from tb.docs.language import ROOT

PAGE = (ROOT / "docs" / "python.md").read_text()
WITHOUT_MACHINE, MACHINE = PAGE.split("## The simulated machine\n")


def run(text, scope):
    for block in re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        exec(block, scope)
    return scope


def test_the_examples(tmp_path, monkeypatch, capsys):
    """The box is 4 x 3 x 2.5, closed and lit; an overcast sky without a sun has 10,000 lux."""
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    scope = run(WITHOUT_MACHINE, {})
    printed = capsys.readouterr().out
    assert "\nnames\n" in printed
    assert "<Scene 'cornell': 20 patches, " in printed
    assert f"{2 * (4 * 3 + 4 * 2.5 + 3 * 2.5):.1f} " in printed
    assert abs(scope["factors"].F.sum(axis=1) - 1).max() < 1e-9
    assert scope["better"].largest_error <= 0.004
    table = scope["factors"].to_dataframe()
    assert list(table.columns) == ["floor", "lamp", "wall", "sky", "back"]
    # Nothing leaves: what the lamp loses the others take.
    assert abs((scope["heat"].flux * scope["stored"].area).sum()) < 1e-6
    assert scope["picture"].image.shape == (48, 64, 3)
    assert (tmp_path / "box.png").read_bytes().startswith(b"\x89PNG")
    assert scope["measured"].illuminance() == pytest.approx(10_000, rel=0.01)
    assert scope["hits"].t == pytest.approx([1.25, 2])
    assert {path.parent.name for path in scope["files"]} >= {"router"}


@pytest.mark.nightly
def test_the_example_of_the_machine():
    """The first cast loads tables and so takes longer."""
    scope = run(MACHINE, {"radiosity": radiosity, "room": radiosity.load("cornell")})
    result = scope["result"]
    assert result.agrees
    assert result.patch.shape == (16, 64)
    assert result.cycles[0] > result.cycles[1]


@pytest.mark.parametrize("name", radiosity.__all__)
def test_public_names_are_on_the_page(name):
    assert re.search(rf"\b{name}\b", PAGE)
