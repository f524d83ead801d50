"""Fixtures of the tests of exported cores."""

import dataclasses

import pytest

from hw.package.tops import TOPS


@pytest.fixture
def without_verilog(monkeypatch):
    """Exports of engines whose Verilog is empty."""
    monkeypatch.setitem(TOPS, "engine", dataclasses.replace(TOPS["engine"], text=lambda *_: ""))
    monkeypatch.setattr("hw.package.manifest.unit_latencies", lambda *_: {})
