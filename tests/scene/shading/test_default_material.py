# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and slots without a material get one to relight, and lose it again."""


def test_objects_without_material_get_one_and_lose_it(blender, part, scene, stage):
    """No slot, or an empty slot: both are as before after removal."""
    shading = part("shading")
    bare = stage.object_of("Bare", stage.cube())
    empty = stage.object_of("Empty", stage.cube())
    empty.data.materials.append(None)
    shading.add_shading([bare, empty])
    assert bare.data.materials[0] and bare.data.materials[0] == empty.data.materials[0]
    shading.remove_shading([bare, empty])
    assert len(bare.data.materials) == 0
    assert list(empty.data.materials) == [None]
    assert not blender.data.materials
