from benchmarks.shooting import shot_row
from golden.scene.open import open_scene


def test_a_third_of_the_rows_suffices_and_groups_take_few_more_shots():
    found = shot_row(open_scene("room1627"), (32, 16), "grid")
    assert found.rows == 1297
    assert found.cast <= found.rows / 3
    assert found.grouped <= 1.15 * found.plain
