# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials get the relight group beside their own nodes, and are given back as they were."""


def test_add_remove_add_restores_the_tree(blender, part, scene, stage):
    """Node by node, setting by setting, link by link."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    tree = ob.data.materials[0].node_tree
    before = stage.node_snapshot(tree)
    for _ in range(2):
        shading.add_shading([ob])
        assert stage.node_snapshot(tree) != before
        assert tree.get_output_node("CYCLES").name in before[0], "Cycles renders the user's own"
        shading.remove_shading([ob])
        assert stage.node_snapshot(tree) == before


def test_adding_twice_is_adding_once(part, scene, stage):
    """A second bake replaces the nodes instead of piling them up."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    shading.add_shading([ob])
    once = stage.node_snapshot(ob.data.materials[0].node_tree)
    shading.add_shading([ob])
    assert stage.node_snapshot(ob.data.materials[0].node_tree) == once


def test_own_eevee_output_becomes_active_again(part, scene, stage):
    """A material that had an EEVEE output of its own gets it back."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    tree = ob.data.materials[0].node_tree
    own = tree.nodes.new("ShaderNodeOutputMaterial")
    own.target = "EEVEE"
    tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], own.inputs["Surface"])
    before = stage.node_snapshot(tree)
    shading.add_shading([ob])
    assert tree.get_output_node("EEVEE") != own
    shading.remove_shading([ob])
    assert tree.get_output_node("EEVEE") == own
    assert before[0] == stage.node_snapshot(tree)[0]
    assert stage.node_snapshot(tree) == before


def test_material_of_other_baked_objects_stays_hooked_up(blender, part, scene, stage):
    """Removing one object leaves the material that another baked object shows."""
    material = stage.diffuse()
    one = stage.object_of("One", stage.cube(), material)
    stage.object_of("Two", stage.cube(), material, (4, 0, 0))
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="UNSHADOWED")
    one.select_set(True)
    blender.ops.prt.remove()
    assert list(part("our_nodes").our_nodes(material.node_tree))
    assert not part("layers").is_baked(one.data)
