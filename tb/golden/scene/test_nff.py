import numpy as np
import pytest

from golden.base.errors import InputError, InputWarning
from golden.scene.nff import read_nff

VIEW = """v
from 2.1 1.3 1.7
at 0 0 0
up 0 1 1
angle 45
hither 0.01
resolution 512 256
"""

WHOLE = """# all entities
b 0.078 0.361 0.753
""" + VIEW + """l 4 3 2
l 1 -4 4 1 0.5 0.25
f 1 0.75 0.33 0.8 0 0 0 0
p 4
12 12 -0.5
-12 12 -0.5   # a comment
-12 -12 -0.5
12 -12 -0.5
f 1 0.9 0.7 0.5 0.5 3.0827 0.25 1.5
s 0 0 0 0.5
c
0 0 1 0.25
0 0 2 0
f 1 0.75 0.33 0.8 0 0 0 0
pp 3
0 0 3  0 0 1
1 0 3  0 0 1
0 1 3  0 0 1
pp 3
1 0 3  0 0 1
1 1 3.1  0 0 1
0 1 3  0 0 1
"""


@pytest.fixture(scope="module")
def whole():
    with pytest.warns(InputWarning, match="^not used: shares beyond a sum of 1$"):
        return read_nff(WHOLE.encode(), "dir/whole.nff")


def test_view_becomes_the_camera(whole):
    assert whole.name == "whole"
    assert whole.camera.eye == (2.1, 1.3, 1.7)
    assert whole.camera.target == (0, 0, 0)
    assert whole.camera.up == whole.up == (0, 1, 1)
    assert whole.camera.fov == 45


def test_background_is_read(whole):
    assert whole.background == (0.078, 0.361, 0.753)


def test_lights_irradiate_the_middle_with_pi_over_root_n(whole):
    middle = whole.bounds.mean(axis=0)
    for light, color in zip(whole.lights, ((1, 1, 1), (1, 0.5, 0.25)), strict=True):
        squared = ((middle - light.position) ** 2).sum()
        assert np.array(light.intensity) / squared == pytest.approx(np.pi / np.sqrt(2) * np.array(color))


def test_light_in_the_middle_counts_as_a_tenth_of_the_diagonal_away():
    scene = read_nff(b"l 0 0 0\ns 0 0 0 1", "x.nff")
    diagonal = np.linalg.norm(scene.bounds[1] - scene.bounds[0])
    assert scene.lights[0].intensity == pytest.approx([np.pi * (0.1 * diagonal) ** 2] * 3)


def test_objects_become_patches_with_sides_surfaces_and_groups(whole):
    polygon, ball, cone, patch = np.split(np.arange(len(whole)), np.cumsum([1, 16 * 8, 16]))
    assert len(patch) == 2
    assert whole.two_sided[polygon].all()
    assert whole.two_sided[patch].all()
    assert not whole.two_sided[ball].any()
    assert not whole.two_sided[cone].any()
    for group in (ball, cone, patch):
        assert len(set(whole.smooth[group])) == 1
        assert len(set(whole.surface[group])) == len(group)
    assert len(set(whole.smooth)) == 4
    outward = (whole.normals[ball] * whole.vertices[ball].mean(axis=1)).sum(axis=1)
    assert outward.min() > 0.4
    assert whole.bounds.tolist() == [[-12, -12, -0.5], [12, 12, 3.1]]


def test_fills_become_materials_that_never_give_more_than_they_get(whole):
    matte, glass = whole.materials
    assert matte.diffuse == pytest.approx((0.8, 0.6, 0.264))
    assert matte.specular == matte.transparent == (0, 0, 0)
    assert matte.refraction_index == 1
    # Kd + Ks + T = 1.25 in red.
    assert glass.diffuse == pytest.approx((0.4, 0.36, 0.28))
    assert glass.specular == pytest.approx((0.4, 0.4, 0.4))
    assert glass.transparent == pytest.approx((0.2, 0.18, 0.14))
    assert glass.refraction_index == 1.5
    assert whole.material[0] == whole.material[-1] == 0


def test_a_fill_ends_a_smooth_surface():
    """Its material is the one before, whatever follows."""
    fills = [f"f {red} 0 0 1 0 0 0 0\n" for red in (1, 0.5, 0.25)]
    surfaces = [f"pp 3\n0 0 {z} 0 0 1\n1 0 {z} 0 0 1\n0 1 {z} 0 0 1\n" for z in (0, 1)]
    text = fills[0] + surfaces[0] + fills[1] + surfaces[1] + fills[2] + "s 0 0 5 1"
    scene = read_nff(text.encode(), "x.nff")
    assert scene.channels("diffuse")[:, 0].tolist() == [1, 0.5, *[0.25] * (len(scene) - 2)]
    assert len(set(scene.smooth[:3])) == 3


def test_objects_before_a_fill_are_light_grey():
    assert read_nff(b"s 0 0 0 1", "x.nff").materials[0].diffuse == (0.7, 0.7, 0.7)


def test_many_spheres_are_refused_before_they_fill_the_memory(monkeypatch):
    monkeypatch.setattr("golden.scene.nff.MOST_ROUND", 300)
    assert len(read_nff(b"s 0 0 0 1\ns 3 0 0 1\n", "a")) == 256
    with pytest.raises(InputError, match=r"^a:3: its spheres, cones and cylinders have more than 300 patches$"):
        read_nff(b"s 0 0 0 1\n" * 4, "a")


@pytest.mark.parametrize(("text", "message"), [
    ("q 1 2 3", "bad.nff:1: unknown entity 'q'"),
    ("s 0 0 0 1\n\nhello", "bad.nff:3: unknown entity 'hello'"),
    ("1 2 3\ns 0 0 0 1", "bad.nff:1: unknown entity '1'"),
    ("s 0 0 0", "bad.nff:1: 's' needs 4 values, not 3"),
    ("s 0 0 0 1 2", "bad.nff:1: 's' needs 4 values, not 5"),
    ("# c\ns 0 0 zero 1", "bad.nff:2: 'zero' is not a number"),
    ("s 0 0 0 1_0", "bad.nff:1: '1_0' is not a number"),
    ("s 0 0 nan 1", "bad.nff:1: 'nan' is not a finite number"),
    ("s 0 0 1e999 1", "bad.nff:1: '1e999' is not a finite number"),
    ("s 0 0 0 1e200", "bad.nff:1: '1e200' is beyond 1e+30"),
    ("s 0 0 0 0", "bad.nff:1: Radius must be a finite value above 0, not 0.0"),
    ("c\n0 0 0 -1\n0 0 1 -1", "bad.nff:1: Base radius must be a finite value of at least 0, not -1.0"),
    ("c\n0 0 0 1\n0 0 1", "bad.nff:1: 'c' needs 8 values, not 7"),
    ("p 2\n0 0 0\n1 0 0", "bad.nff:1: 'p' needs at least 3 vertices, not 2"),
    ("p\nf 1 1 1 1 0 0 0 0", "bad.nff:1: 'p' needs a whole number of vertices"),
    ("p 3.5\n0 0 0", "bad.nff:1: 'p' needs a whole number of vertices"),
    ("p 4\n0 0 0\n1 0 0\n1 1 0", "bad.nff:1: 'p 4' needs 12 values, not 9"),
    ("p 1000000000\n0 0 0", "bad.nff:1: 'p 1000000000' needs 3000000000 values, not 3"),
    ("pp 3\n0 0 0\n1 0 0\n1 1 0", "bad.nff:1: 'pp 3' needs 18 values, not 9"),
    ("s 0 0 0 1\np 3\n0 0 0\n1 0 0\n2 0 0", "bad.nff:2: polygon: it has no area"),
    ("", "bad.nff: it has no object (s, c, p, pp)"),
    (VIEW, "bad.nff: it has no object (s, c, p, pp)"),
    ("v\nfrom 1 0 0\nat 0 0 0\nup 0 0 1\ns 0 0 0 1", "bad.nff:1: the view has no 'angle'"),
    ("s 0 0 0 1\nv\nfrom 1 0 0", "bad.nff:2: the view has no 'at'"),
    ("s 0 0 0 1\nfrom 1 0 0", "bad.nff:2: 'from' is not within a view ('v')"),
    ("s 0 0 0 1\nv\nat 0 0 0\nat 1 0 0", "bad.nff:4: the view has a second 'at'"),
    ("v 1\nfrom 1 0 0\nat 0 0 0\nup 0 0 1\nangle 45\ns 0 0 0 1", "bad.nff:1: 'v' needs 0 values, not 1"),
    (VIEW.replace("angle 45", "angle 180") + "s 0 0 0 1",
     "bad.nff:1: camera: Field of view must be between 0 and 180 degrees, not 180.0"),
    ("l 1 2 3 4\ns 0 0 0 1", "bad.nff:1: 'l' needs 3 or 6 values, not 4"),
    ("l 1 2 3 -1 0 0\ns 0 0 0 1", "bad.nff:1: the light's colour must not be negative, not (-1.0, 0.0, 0.0)"),
    ("b 0 -1 0\ns 0 0 0 1", "bad.nff:1: the background must not be negative, not (0.0, -1.0, 0.0)"),
    ("f 1 1 1 1 0 0 0\ns 0 0 0 1", "bad.nff:1: 'f' needs 8 values, not 7"),
    ("f 1 1 1 -1 0 0 0 0\ns 0 0 0 1", "bad.nff:1: colour, Kd, Ks and T of a fill must not be negative"),
    ("f 1 1 1 0 0 0 1 0.5\ns 0 0 0 1",
     "bad.nff:1: material 'fill 1': Refraction index must be a finite value of at least 1, not 0.5"),
])
def test_bad_file_is_one_line_with_its_position(text, message):
    with pytest.raises(InputError) as caught:
        read_nff(text.encode(), "bad.nff")
    assert str(caught.value) == message
