# SPDX-License-Identifier: GPL-3.0-or-later
"""All that renders casts shadows and bounces light, whatever it is made of; what is hidden from renders does neither."""

import pytest

from tests.scene.bake.builders import BUILDERS, collection_instances, filled_curve, metaball, text
from tests.scene.bake.measures import extra_area


@pytest.mark.parametrize("build", BUILDERS)
def test_everything_is_there_once(blender, part, ground, stage, build):
    """As often and as large as it renders; and not at all when hidden from renders."""
    ob, area = build(blender, stage)
    found = extra_area(part, blender, ground)
    assert found == pytest.approx(area, rel=0.01) if area else found > 0.5
    ob.hide_render = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("build", BUILDERS)
def test_everything_occludes_and_bounces(blender, part, ground, stage, build):
    """The ground below is darker for it, and the light that comes off it is red."""
    build(blender, stage)
    read = part("layers").read
    options = {"samples": 256, "update_light": False, "update_shading": False}
    blender.ops.prt.bake(mode="SHADOWED", **options)
    shadowed = read(ground.data)[:, 0].mean(axis=0)
    assert (shadowed < 0.27).all(), "0.2821 without it"
    blender.ops.prt.bake(mode="INTERREFLECTED", bounces=1, **options)
    red, green, blue = read(ground.data)[:, 0].mean(axis=0) - shadowed
    assert red > 1e-4 and abs(green) < 1e-6 and abs(blue) < 1e-6


def test_metaballs_of_a_family_and_hair(blender, part, ground, stage):
    """The family is one surface; hair strands have none, and are no error."""
    _, _ = metaball(blender, stage)
    one = extra_area(part, blender, ground)
    metaball(blender, stage)[0].location = (50, 0, 1)
    assert extra_area(part, blender, ground) == pytest.approx(2 * one, rel=0.01)
    hair = blender.data.hair_curves.new("Hair")
    hair.add_curves([3])
    blender.context.scene.collection.objects.link(blender.data.objects.new("Hair", hair))
    assert extra_area(part, blender, ground) == pytest.approx(2 * one, rel=0.01)


@pytest.mark.parametrize("build", [filled_curve, text, metaball])
def test_what_casts_no_shadow_casts_none(blender, part, ground, stage, build):
    """Ray Visibility > Shadow is the user's word on it."""
    ob, _ = build(blender, stage)
    ob.visible_shadow = False
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


def test_shadow_visibility_of_instances(blender, part, ground, stage):
    """It is that of the object which is shown."""
    empty, _ = collection_instances(blender, stage)
    empty.instance_collection.objects[0].visible_shadow = False
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("build", [filled_curve, text, metaball])
def test_what_is_no_mesh_does_not_receive(blender, part, ground, stage, build):
    """Selected or not: there is nothing to store transport on, and it is no error."""
    ob, _ = build(blender, stage)
    ob.select_set(True)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16, update_shading=False) == {"FINISHED"}
    assert part("layers").is_baked(ground.data)


def test_render_visibility_of_collections(blender, part, scene, ground, stage):
    """What a collection hides from renders, or a view layer excludes, takes no part."""
    ob, area = filled_curve(blender, stage)
    group = blender.data.collections.new("Group")
    scene.collection.children.link(group)
    group.objects.link(ob)
    scene.collection.objects.unlink(ob)
    assert extra_area(part, blender, ground) == pytest.approx(area)
    group.hide_render = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)
    group.hide_render = False
    blender.context.view_layer.layer_collection.children["Group"].exclude = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)
