# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes materials to read colours of, and reads what a bake reads of them."""

import numpy as np


def sentences(plan):
    return [notice.sentence for notice in plan.notices]


def plan_albedo(part, bpy, ob):
    plan = part("read").read_bake(bpy.context, [ob], part("problem").BakeSettings("INTERREFLECTED"))
    return plan.scene.occluders.albedo, plan


def triangle_of(plan, ob):
    """The plan's first triangle of an object: surfaces are laid out by what they are, not by name."""
    middles = plan.scene.occluders.vertices[plan.scene.occluders.triangles].mean(axis=1)
    return np.flatnonzero(np.abs(middles - np.array(ob.location)).max(axis=1) < 1.0)[:1]


def middle():
    return np.full((2, 1), 1 / 3, dtype=np.float32)


def lower_left_red(ob):
    """UVs that lay the picture over the grid of size 2."""
    mesh = ob.data
    mesh.uv_layers.new()
    co = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
    mesh.uv_layers.active.data.foreach_set("uv", (co / 2 + 0.5).ravel())


def node_into_colour(material, kind, output):
    """Feed the material's shader by a new node."""
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.bl_idname.startswith("ShaderNodeBsdf"))
    node = tree.nodes.new(kind)
    tree.links.new(node.outputs[output], shader.inputs[0])
    return node


def principled(bpy, **inputs):
    from headless import use_nodes

    material = bpy.data.materials.new("Principled")
    use_nodes(material)
    for name, value in inputs.items():
        material.node_tree.nodes["Principled BSDF"].inputs[name.replace("_", " ")].default_value = value
    return material


def shader_material(bpy, *shaders):
    """A material of some shaders, (type, colour) each, mixed in equal parts."""
    from headless import use_nodes

    material = bpy.data.materials.new("Several")
    use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    made = []
    for kind, colour in shaders:
        node = tree.nodes.new(kind)
        node.inputs[0].default_value = (*colour, 1.0)
        made.append(node.outputs[0])
    while len(made) > 1:
        mix = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(made.pop(), mix.inputs[1])
        tree.links.new(made.pop(), mix.inputs[2])
        made.append(mix.outputs[0])
    tree.links.new(made[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def whereabouts(bpy):
    """Everything that an evaluation must leave as it was."""
    counts = {
        collection.identifier: sorted(each.name for each in getattr(bpy.data, collection.identifier))
        for collection in bpy.data.bl_rna.properties
        if collection.type == "COLLECTION"
    }
    scene, active = bpy.context.scene, bpy.context.view_layer.objects.active
    users = [(each.name, each.users) for kind in (bpy.data.materials, bpy.data.meshes) for each in kind]
    selected = sorted(ob.name for ob in bpy.context.selected_objects)
    return counts, users, scene.name, scene.render.engine, active and active.name, selected
