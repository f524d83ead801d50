"""Shares of materials of MTL and of glTF by their definitions, with all members combined and at their ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.scene.gltf_material import gltf_material
from golden.scene.mtl import read_mtl
from tb.lib.schedules import SETTINGS

SHARE = st.sampled_from((0.0, 0.25, 0.5, 1.0))
COLOUR = st.tuples(SHARE, SHARE, SHARE)
INDEX = st.sampled_from((1.0, 1.5, 2.0))


def stated(**members):
    """Some of these members, each drawn."""
    return st.fixed_dictionaries({}, optional=members)


def assert_is(material, *, diffuse, specular, transparent, emission, index):
    """The shares, scaled down together where they sum to more than 1."""
    whole = np.maximum(np.sum([diffuse, specular, transparent], axis=0), 1)
    for name, values in (("diffuse", diffuse), ("specular", specular), ("transparent", transparent)):
        assert getattr(material, name) == pytest.approx(tuple(values / whole)), name
    assert material.emission == pytest.approx(tuple(emission))
    assert material.refraction_index == pytest.approx(index)


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@settings(SETTINGS, max_examples=100)
@given(stated(Kd=COLOUR, Ks=COLOUR, Tf=COLOUR, Ke=COLOUR, Ni=INDEX, d=SHARE, Tr=SHARE,
              Ns=st.sampled_from((0, 499.99, 500, 1000)), illum=st.integers(0, 9)))
def test_an_mtl_material_has_the_shares_that_its_members_state(members):
    lines = ["newmtl a", *(f"{key} {' '.join(map(str, np.atleast_1d(value)))}" for key, value in members.items())]
    material = read_mtl("\n".join(lines).encode(), where="a.mtl")["a"].material()
    opacity = members.get("d", 1 - members.get("Tr", 0))
    shines = members.get("illum", 2) >= 3 or members.get("Ns", 0) >= 500
    refracts = "Ni" in members and members.get("illum", 2) >= 4
    assert_is(material, diffuse=opacity * np.array(members.get("Kd", (0.5, 0.5, 0.5))),
              specular=np.array(members.get("Ks", (0, 0, 0))) * shines, emission=members.get("Ke", (0, 0, 0)),
              transparent=(1 - opacity) * np.array(members.get("Tf", (1, 1, 1))),
              index=members.get("Ni", 1.5) if opacity == 1 or refracts else 1)


@settings(SETTINGS, max_examples=100)
@given(pbr=stated(baseColorFactor=st.tuples(*[SHARE] * 4), metallicFactor=SHARE,
                  roughnessFactor=st.sampled_from((0.0, 0.25, 0.2501, 1.0))),
       more=stated(emissiveFactor=COLOUR, alphaMode=st.sampled_from(("OPAQUE", "BLEND"))),
       extensions=stated(transmission=SHARE, ior=INDEX, volume=st.sampled_from((0.0, 0.5)), emissive_strength=INDEX))
def test_a_gltf_material_has_the_shares_that_its_members_state(pbr, more, extensions):
    members = {"transmission": "transmissionFactor", "ior": "ior", "volume": "thicknessFactor",
               "emissive_strength": "emissiveStrength"}
    source = {"pbrMetallicRoughness": pbr, **more, "extensions": {
        f"KHR_materials_{name}": {members[name]: value} for name, value in extensions.items()}}
    *base, alpha = pbr.get("baseColorFactor", (1, 1, 1, 1))
    base, metal = np.array(base), pbr.get("metallicFactor", 1)
    alpha = alpha if more.get("alphaMode") == "BLEND" else 1
    passed, is_mirror = extensions.get("transmission", 0), pbr.get("roughnessFactor", 1) <= 0.25
    transparent = alpha * passed * (1 - metal) * base + 1 - alpha
    is_open_sheet = transparent.any() and not passed and not extensions.get("volume", 0)
    assert_is(gltf_material(source, "a"),
              diffuse=alpha * ((1 - passed) * (1 - metal) * base + (0 if is_mirror else metal * base)),
              specular=alpha * metal * base * is_mirror, transparent=transparent,
              index=1 if is_open_sheet else extensions.get("ior", 1.5),
              emission=np.multiply(more.get("emissiveFactor", (0, 0, 0)), extensions.get("emissive_strength", 1)))
