from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.base.library_versions import library_versions
from golden.engine.cast.methods import FRUSTUM_METHODS
from radiosity.workers.proof import Proof


@pytest.mark.parametrize("method", FRUSTUM_METHODS)
def test_a_process_agrees_with_itself(method):
    proof = Proof.of_this_process(method)
    proof.check()
    assert proof.versions["numpy"] == np.__version__


def test_brute_force_and_the_grid_compute_the_same_test():
    assert Proof.of_this_process("naive").canary == Proof.of_this_process("grid").canary
    assert Proof.of_this_process("naive").canary != Proof.of_this_process("shelling").canary


@pytest.mark.parametrize("library", library_versions())
def test_another_version_is_refused(library):
    proof = Proof.of_this_process("naive")
    other = replace(proof, versions=proof.versions | {library: "0.0"}, canary="")
    with pytest.raises(InputError, match=rf"^worker on .*: {library} must be 0\.0, not [\w.]+$"):
        other.check()


def test_other_sources_of_the_same_version_are_refused():
    with pytest.raises(InputError, match=r"^worker on .*: it has other sources .* must be abc, not [0-9a-f]{12}$"):
        replace(Proof.of_this_process("naive"), sources="abc").check()


def test_other_bits_are_refused():
    with pytest.raises(InputError, match=r"^worker on .*: it computes other bits .* must be abc, not [0-9a-f]{12}$"):
        replace(Proof.of_this_process("naive"), canary="abc").check()
