# SPDX-License-Identifier: GPL-3.0-or-later
"""A roof blocks light where renders, and their diffuse and shadow rays, see it, whatever the viewport shows."""

import pytest

from tests.scene.bake.measures import shadow


def roof_over(stage, name="Roof"):
    return stage.object_of(name, stage.grid(1, 2.0), location=(0, 0, 0.5))


def hidden_here(ob):
    ob.hide_set(True)


def disabled_here(ob):
    ob.hide_viewport = True


def made_by_a_modifier(ob):
    """Half a roof, whose other half renders only."""
    for vertex in ob.data.vertices:
        vertex.co.x = max(vertex.co.x, 0.0)
    mirror = ob.modifiers.new("Mirror", "MIRROR")
    mirror.show_viewport = False


def hidden_with_modifiers(ob):
    made_by_a_modifier(ob)
    ob.hide_viewport = True


@pytest.mark.parametrize("change", [hidden_here, disabled_here, made_by_a_modifier, hidden_with_modifiers])
def test_renders_count_and_not_the_viewport(blender, part, floor, stage, change):
    """The same shadow as of a roof that the viewport shows, too; none once it does not render."""
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    assert whole < 0.3
    change(roof)
    assert shadow(part, blender, floor) == pytest.approx(whole, abs=0.01)
    roof.hide_render = True
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)


def test_levels_of_renders_are_baked(blender, part, floor, stage):
    """Subdivision 0 here and 3 in renders: the values are those of the round thing."""
    ob = stage.object_of("Ball", stage.cube(1.0), location=(0, 0, 3))
    modifier = ob.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    [one] = part("read").read_bake(blender.context, [ob]).objects
    assert one.carried.counts[0] == 386 and one.elements == (8, 24)


def test_a_background_set_blocks_light(blender, part, scene, floor, stage):
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    backdrop = blender.data.scenes.new("Backdrop")
    backdrop.collection.objects.link(roof)
    scene.collection.objects.unlink(roof)
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    scene.background_set = backdrop
    assert shadow(part, blender, floor) == pytest.approx(whole)


def test_emitters_that_are_not_shown_do_not_block(blender, part, floor, stage):
    roof = roof_over(stage)
    roof.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings.type = "HAIR"
    assert shadow(part, blender, floor) < 0.3
    roof.show_instancer_for_render = False
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)


def test_rays_that_do_not_see_it(blender, part, floor, stage):
    """Hidden from diffuse or shadow rays it blocks nothing; hidden from all others, or a holdout, it does."""
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    for name in ("visible_diffuse", "visible_shadow"):
        setattr(roof, name, False)
        assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3), name
        setattr(roof, name, True)
    for name in ("visible_camera", "visible_glossy", "visible_transmission", "visible_volume_scatter"):
        setattr(roof, name, False)
    roof.is_holdout = True
    assert shadow(part, blender, floor) == pytest.approx(whole)


def test_what_casts_no_shadow_still_receives(blender, part, floor, stage):
    """Alone, or beside others that it does not shade."""
    floor.visible_shadow = False
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    roof = roof_over(stage)
    roof.visible_shadow = False
    assert shadow(part, blender, floor, roof) == pytest.approx(1.0, abs=1e-3)


def volume(nodes, links):
    scatter, output = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeOutputMaterial")
    links.new(scatter.outputs[0], output.inputs["Volume"])


def test_fog_is_no_surface(blender, part, scene, floor, stage):
    """It blocks no light, and its material is left alone."""
    material = stage.diffuse("Fog")
    material.node_tree.nodes.clear()
    volume(material.node_tree.nodes, material.node_tree.links)
    fog = stage.object_of("Fog", stage.cube(), material)
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    fog.select_set(True)
    floor.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert not list(part("our_nodes").our_nodes(material.node_tree))


def test_outlines_do_not_blacken_what_they_enclose(blender, part, floor, stage):
    """A turned-over hull whose back faces are culled lets light in; from outside it blocks."""
    hull = stage.cube(1.5)
    hull.flip_normals()
    material = stage.diffuse("Outline")
    outline = stage.object_of("Outline", hull, material)
    assert shadow(part, blender, floor) < 0.01
    material.use_backface_culling = True
    outline.data.flip_normals()
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    outline.data.flip_normals()
    assert shadow(part, blender, floor) < 0.01, "rays from within meet the fronts of a turned-over hull"
