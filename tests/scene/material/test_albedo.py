# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedo as light finds it: what is read from real materials, and what Cycles evaluates instead."""

import numpy as np
import pytest

Colour = tuple[float, float, float]


def sentences(plan):
    return [notice.sentence for notice in plan.notices]


def plan_albedo(part, bpy, ob):
    plan = part("read").read_bake(bpy.context, [ob], part("problem").BakeSettings("INTERREFLECTED"))
    return plan.scene.occluders.albedo, plan


def triangle_of(plan, ob):
    """The plan's first triangle of an object: surfaces are laid out by what they are, not by name."""
    middles = plan.scene.occluders.vertices[plan.scene.occluders.triangles].mean(axis=1)
    return np.flatnonzero(np.abs(middles - np.array(ob.location)).max(axis=1) < 1.0)[:1]


def test_constant_texture_and_attribute(blender, part, scene, stage):
    """Three objects, three kinds; looked up at the middle of a triangle."""
    plain = stage.object_of("A", stage.grid(1, 1.0), stage.diffuse(colour=(0.1, 0.2, 0.3)))
    albedo, _ = plan_albedo(part, blender, plain)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.1, 0.2, 0.3]], rtol=1e-6)

    textured = stage.object_of("B", stage.grid(1, 1.0), stage.diffuse("Textured"), (5, 0, 0))
    lower_left_red(textured)
    tree = textured.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texels = np.zeros((2, 2, 3))
    texels[0, 0] = (1.0, 0.0, 0.0)
    texture.image, texture.interpolation = stage.picture("Texels", texels), "Closest"
    tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, plan = plan_albedo(part, blender, textured)
    mine = triangle_of(plan, textured)
    (corner,) = plan.scene.occluders.vertices[plan.scene.occluders.triangles[mine]]
    nearest = int(np.argmin(corner[:, 0] + corner[:, 1]))  # the lower left corner, where the texel is red
    u, v = (np.array([1.0 if nearest == k else 0.0], dtype=np.float32) * 0.9 for k in (1, 2))
    np.testing.assert_allclose(albedo.at(mine, u, v), [[1, 0, 0]])

    coloured = stage.object_of("C", stage.grid(1, 1.0), stage.diffuse("Coloured"), (10, 0, 0))
    layer = coloured.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.tile([0.5, 0.25, 0.125, 1.0], len(layer.data)))
    tree = coloured.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, plan = plan_albedo(part, blender, coloured)
    np.testing.assert_allclose(albedo.at(triangle_of(plan, coloured), *middle()), [[0.5, 0.25, 0.125]], rtol=1e-6)


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


def test_cycles_evaluates_what_is_not_read(blender, part, scene, stage):
    """A colour that is a function of position: the very values, on the faces of that slot only, and it is said."""
    ob = stage.object_of("A", stage.grid(4, 1.0), stage.diffuse("Plain", (0.1, 0.2, 0.3)), (5.0, 6.0, 7.0))
    special = stage.diffuse("Special")
    node_into_colour(special, "ShaderNodeTexCoord", "Object")
    ob.data.materials.append(special)
    right = np.array([face.center.x > 0 for face in ob.data.polygons])
    ob.data.polygons.foreach_set("material_index", right.astype(np.int32))
    albedo, plan = plan_albedo(part, blender, ob)
    triangle = np.arange(len(plan.scene.occluders.triangles))
    position = plan.scene.occluders.vertices[plan.scene.occluders.triangles] - (5.0, 6.0, 7.0)
    at_corner_1 = albedo.at(triangle, np.ones(len(triangle), np.float32), np.zeros(len(triangle), np.float32))
    here = position[:, :, 0].mean(axis=1) > 0
    np.testing.assert_allclose(at_corner_1[here], np.clip(position[here, 1], 0, 1), atol=1e-3)
    np.testing.assert_allclose(at_corner_1[~here], np.tile([[0.1, 0.2, 0.3]], (np.sum(~here), 1)), rtol=1e-6)
    assert sentences(plan) == [
        "Material 'Special': its colour comes from 'Texture Coordinate'; Cycles evaluated it at the vertices."
    ]


def test_evaluation_leaves_no_trace(blender, part, scene, stage):
    """Data-blocks and their users, selection, active object and engine; in two scenes and any mode."""
    noisy = stage.diffuse("Noisy")
    node_into_colour(noisy, "ShaderNodeTexNoise", "Color")
    one = stage.object_of("One", stage.grid(4), noisy)
    several = shader_material(blender, ("ShaderNodeBsdfGlass", (1, 1, 1)), ("ShaderNodeBsdfDiffuse", (1, 0, 0)))
    node_into_colour(several, "ShaderNodeTexNoise", "Color")
    two = stage.object_of("Two", stage.grid(2), several, (3, 0, 0))
    blender.context.view_layer.objects.active = two
    one.select_set(True)
    before = whereabouts(blender)
    _, plan = plan_albedo(part, blender, one)
    assert len(plan.notices) == 2 and all("Cycles evaluated it" in said for said in sentences(plan))
    assert whereabouts(blender) == before


def test_colour_of_a_metal_and_of_what_is_transparent(blender, part, scene, stage):
    """Metallic and alpha change neither way of finding the colour."""
    colour = (0.6, 0.3, 0.1, 1.0)
    direct = principled(blender, Base_Color=colour, Metallic=1.0, Alpha=0.25)
    by_cycles = principled(blender, Metallic=1.0, Alpha=0.25)
    combined = node_into_colour(by_cycles, "ShaderNodeCombineColor", 0)
    for k in range(3):
        combined.inputs[k].default_value = colour[k]
    for material in (direct, by_cycles):
        ob = stage.object_of("Metal", stage.grid(1), material)
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [colour[:3]], rtol=1e-4)
        blender.data.objects.remove(ob)


def test_materials_of_several_shaders(blender, part, scene, stage):
    """What they reflect adds up, glossy or not; what they let through does not count."""
    red, green, blue = (0.8, 0, 0), (0, 0.8, 0), (0, 0, 0.8)
    diffuse, glossy, clear = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfTransparent"
    cases: list[tuple[list[tuple[str, Colour]], Colour]] = [
        ([(diffuse, red), (diffuse, green)], (0.4, 0.4, 0)),
        ([(diffuse, red), (glossy, blue)], (0.4, 0, 0.4)),
        ([(glossy, blue)], blue),
        ([(diffuse, red), (clear, (1, 1, 1))], red),
        ([(glossy, green), (clear, (1, 1, 1))], green),
    ]
    for shaders, expected in cases:
        ob = stage.object_of("Mixed", stage.grid(1), shader_material(blender, *shaders))
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], expected, atol=0.02, err_msg=str(shaders))
        blender.data.objects.remove(ob)


@pytest.mark.parametrize(
    ("kind", "output", "evaluations"), [("ShaderNodeNewGeometry", "Position", 2), ("ShaderNodeTexNoise", 1, 1)]
)
def test_unread_colours_of_instances(blender, part, scene, stage, monkeypatch, kind, output, evaluations):
    """Each where it stands, if its colour depends on the place in the world; else once for all."""
    material = stage.diffuse("Placed")
    node_into_colour(material, kind, output)
    thing = stage.object_of("Thing", stage.grid(1, 0.01), material, (0, 0, 0))
    holder = blender.data.collections.new("Holder")
    scene.collection.objects.unlink(thing)
    holder.objects.link(thing)
    for x in (0.25, 0.75):
        empty = blender.data.objects.new("Instancer", None)
        empty.location, empty.instance_type, empty.instance_collection = (x, 0, 0), "COLLECTION", holder
        scene.collection.objects.link(empty)
    ground = stage.object_of("Ground", stage.grid(1), location=(0, 0, -1))
    module, evaluated, counted = part("cycles_colour"), [], part("notices").counted
    bake = module._baked
    monkeypatch.setattr(module, "_baked", lambda *args: evaluated.append(args[1]) or bake(*args))
    albedo, plan = plan_albedo(part, blender, ground)
    assert evaluated == ["DIFFUSE"] * evaluations
    assert [one.names for one in counted(plan.notices) if "Cycles evaluated it" in one.sentence] == [("Placed",)], (
        "once"
    )
    count = len(plan.scene.occluders.triangles)
    colours = albedo.at(np.arange(count), *np.full((2, count), 1 / 3, dtype=np.float32))
    if kind == "ShaderNodeNewGeometry":
        np.testing.assert_allclose(np.sort(colours[2:, 0]), [0.25, 0.25, 0.75, 0.75], atol=0.01)
    else:
        np.testing.assert_array_equal(colours[2:4], colours[4:6])
        assert np.ptp(colours[2:4]) > 0


def test_without_cycles_the_viewport_colour_stands_in(blender, part, scene, stage, monkeypatch):
    """Blender refuses to bake, as it does in some contexts: the person is told what is taken instead."""
    ob = stage.object_of("A", stage.grid(1, 1.0), stage.diffuse("Noisy"))
    material = ob.data.materials[0]
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    node_into_colour(material, "ShaderNodeTexNoise", "Color")
    before = whereabouts(blender)

    def refuses(*_args, **_options):
        raise RuntimeError("Operator bpy.ops.object.bake.poll() failed, context is incorrect")

    monkeypatch.setattr(part("cycles_colour"), "_baked", refuses)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.constant[0], (0.2, 0.4, 0.6), rtol=1e-6)
    assert sentences(plan) == [
        "Material 'Noisy': its colour comes from 'Noise Texture'; light takes on its viewport colour."
    ]
    assert whereabouts(blender) == before


def test_missing_image_is_not_pink(blender, part, scene, stage):
    """Cycles shows it in pink; light must not take that on."""
    material = stage.diffuse("Torn")
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    node = node_into_colour(material, "ShaderNodeTexImage", "Color")
    node.image = blender.data.images.new("Lost", 1, 1)
    node.image.source, node.image.filepath = "FILE", "//lost.png"
    ob = stage.object_of("A", stage.grid(1, 1.0), material)
    lower_left_red(ob)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.2, 0.4, 0.6]], rtol=1e-6)
    assert "'Lost' cannot be read" in sentences(plan)[0] and "viewport colour" in sentences(plan)[0]


@pytest.mark.parametrize("where", ["mix of shaders", "box projection", "group", "no image"])
def test_lost_pictures_behind_other_nodes_are_not_pink(blender, part, scene, stage, where):
    """Wherever the picture is missing, Cycles is not asked for a colour that it can only show in pink."""
    material = stage.diffuse("Torn")
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    lost = blender.data.images.new("Lost", 1, 1)
    lost.source, lost.filepath = "FILE", "//lost.png"
    tree = material.node_tree
    if where == "group":
        group = blender.data.node_groups.new("Paint", "ShaderNodeTree")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        node, output = group.nodes.new("ShaderNodeTexImage"), group.nodes.new("NodeGroupOutput")
        group.links.new(node.outputs["Color"], output.inputs[0])
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        tree.links.new(outer.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Color"])
    else:
        node = node_into_colour(material, "ShaderNodeTexImage", "Color")
    node.image = None if where == "no image" else lost
    if where == "box projection":
        node.projection = "BOX"
    if where == "mix of shaders":
        mix, other = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], mix.inputs[1])
        tree.links.new(other.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], next(one for one in tree.nodes if one.type == "OUTPUT_MATERIAL").inputs[0])
    ob = stage.object_of("A", stage.grid(1, 1.0), material)
    lower_left_red(ob)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.2, 0.4, 0.6]], rtol=1e-6)
    named = "no image is chosen" if where == "no image" else "'Lost' cannot be read"
    assert named in sentences(plan)[0] and "viewport colour" in sentences(plan)[0]


def test_lost_pictures_of_many_materials_are_named_as_such(blender, part, scene, stage):
    """Counted by kind, the sentence still says what is wrong and where Blender mends it."""
    lost = blender.data.images.new("Lost", 1, 1)
    lost.source, lost.filepath = "FILE", "//lost.png"
    for name in "AB":
        material = stage.diffuse(f"Torn {name}")
        node_into_colour(material, "ShaderNodeTexImage", "Color").image = lost
        ob = stage.object_of(name, stage.grid(1, 1.0), material)
    _, plan = plan_albedo(part, blender, ob)
    [sentence] = [one.sentence for one in part("notices").counted(plan.notices)]
    assert sentence.startswith("2 materials have lost their pictures") and "Find Missing Files" in sentence
    assert "'Torn A'" in sentence and "'Torn B'" in sentence


def test_light_takes_on_the_colour_it_bounced_off(blender, part, scene, stage):
    """A red wall, unselected, beside a white floor: the floor turns red near it, and only there."""
    floor = stage.object_of("Floor", stage.grid(20, 2.0), stage.diffuse("White", (0.8, 0.8, 0.8)))
    wall = stage.object_of("Wall", stage.grid(20, 2.0), stage.diffuse("Red", (0.8, 0.05, 0.05)), (-2.0, 0, 1.0))
    wall.rotation_euler = (0, 1.5707963, 0)
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    floor.select_set(True)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256, bounces=3)
    transport = part("layers").read(floor.data)
    assert not part("layers").is_baked(wall.data)
    x = np.array([vertex.co.x for vertex in floor.data.vertices])
    redness = transport[:, 0, 0] / transport[:, 0, 2]
    near, far = redness[np.abs(x + 1.8) < 0.15].mean(), redness[x > 1.9].mean()
    assert near > 1.15 > 1.05 > far >= 1.0


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
def test_a_mapped_texture_on_four_vertices(blender, part, scene, stage, kind):
    """The picture is looked up where Cycles does, and not at the vertices alone."""
    ob = stage.object_of("Floor", stage.grid(1, 1.0), stage.diffuse("Tiles"))
    layer = ob.data.uv_layers.new()
    layer.data.foreach_set("uv", np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32).ravel())
    tree = ob.data.materials[0].node_tree
    texture, mapping, uv = (tree.nodes.new(f"ShaderNode{name}") for name in ("TexImage", "Mapping", "UVMap"))
    texture.image = stage.picture("Texels", np.random.default_rng(3).random((16, 16, 3)))
    texture.interpolation = "Closest"
    mapping.vector_type = kind
    values = {"Location": (0.3, -0.2, 0.1), "Rotation": (0.2, -0.1, 0.7), "Scale": (1.7, 0.6, 1.0)}
    for name, value in values.items():
        if name in mapping.inputs:
            mapping.inputs[name].default_value = value
    tree.links.new(uv.outputs[0], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    albedo, plan = plan_albedo(part, blender, ob)
    assert not plan.notices

    fine = stage.object_of("Fine", stage.grid(24, 1.0), ob.data.materials[0], (5, 0, 0))
    places = np.array([list(vertex.co) for vertex in fine.data.vertices])
    corner = np.array([loop.vertex_index for loop in fine.data.loops])
    fine.data.uv_layers.new().data.foreach_set("uv", ((places[corner, :2] + 1) / 2).astype(np.float32).ravel())
    request = part("cycles_colour").ColourRequest(
        fine.evaluated_get(blender.context.evaluated_depsgraph_get()),
        np.eye(4),
        {0: part("cycles_colour").Unread(ob.data.materials[0])},
    )
    truth = request.corner_colours()
    request.close()
    corners = np.array([list(v.co) for v in ob.data.vertices])
    triangle_corner = [list(triangle.vertices) for triangle in ob.data.loop_triangles]
    inside, agree = 0, 0
    for row, vertices in enumerate(triangle_corner):
        a, b, c = corners[vertices][:, :2]
        uvs = np.linalg.solve(np.stack([b - a, c - a], axis=1), (places[:, :2] - a).T).T
        keep = (uvs > 0.01).all(axis=1) & (uvs.sum(axis=1) < 0.99)
        found = albedo.at(np.full(keep.sum(), row), *uvs[keep].T.astype(np.float32))
        by_vertex = np.zeros((len(places), 3))
        by_vertex[corner] = truth
        inside += keep.sum()
        agree += np.isclose(found, by_vertex[keep], atol=2e-3).all(axis=1).sum()
    assert inside > 400 and agree > 0.97 * inside, "texels' edges round either way"


def test_colours_from_custom_properties(blender, part, scene, stage):
    """An object's own, and the scene's, as Attribute nodes read them."""
    for kind, owner in (("OBJECT", None), ("VIEW_LAYER", scene)):
        material = stage.diffuse(kind)
        tree = material.node_tree
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_type, attribute.attribute_name = kind, "paint"
        shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
        tree.links.new(attribute.outputs["Color"], shader.inputs["Color"])
        ob = stage.object_of(kind, stage.grid(1), material)
        (owner or ob)["paint"] = [0.1, 0.4, 0.7]
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], (0.1, 0.4, 0.7), atol=2e-3, err_msg=kind)
        blender.data.objects.remove(ob)


def test_what_the_camera_alone_sees_does_not_bounce(blender, part, scene, stage):
    """Light Path mixes a colour for the camera with one for light."""
    material = stage.diffuse("Two-faced")
    tree = material.node_tree
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    entries = {entry.identifier: entry for entry in mix.inputs}
    entries["A_Color"].default_value, entries["B_Color"].default_value = (0.1, 0.6, 0.2, 1), (0.9, 0, 0, 1)
    tree.links.new(path.outputs["Is Camera Ray"], entries["Factor_Float"])
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    result = next(output for output in mix.outputs if output.identifier == "Result_Color")
    tree.links.new(result, shader.inputs["Color"])
    ob = stage.object_of("Floor", stage.grid(1), material)
    before = whereabouts(blender)
    albedo, _ = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], (0.1, 0.6, 0.2), atol=2e-3)
    assert whereabouts(blender) == before


def test_a_texture_is_decoded_once(blender, part, scene, stage, monkeypatch):
    """Twenty planes with one picture hold it once."""
    material = stage.diffuse("Tiles")
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = stage.picture("Texels", np.random.default_rng(3).random((16, 16, 3)))
    shader = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    for x in range(20):
        stage.object_of(f"Plane {x}", stage.grid(1), material, (3.0 * x, 0, 0)).data.uv_layers.new()
    module, read = part("albedo"), []
    decode = module.linear_pixels
    monkeypatch.setattr(module, "linear_pixels", lambda image: read.append(image) or decode(image))
    albedo, _ = plan_albedo(part, blender, scene.objects[0])
    assert len(read) == 1 and len(albedo.patterns) == 20
    assert len({id(pattern.image) for pattern in albedo.patterns}) == 1
