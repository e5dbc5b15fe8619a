# SPDX-License-Identifier: GPL-3.0-or-later
"""Relit surfaces are the user's own, whole: gloss, alpha, glass, glow, lamps and bent normals, each against Cycles, which shares no shader with us.

The sky holds nothing beyond order 2, so that nine coefficients lose none of it. A ball hovers over a floor: it is lit by the
sky, shadows the floor, and mirrors both.
"""

from math import cos, radians, sin, tan
from typing import Any

import numpy as np
import pytest

RESOLUTION = 48
GOLD = (0.9, 0.6, 0.2, 1.0)
TILT = radians(12.0)


@pytest.fixture
def over_a_floor(blender, stage):
    """Put a ball of a material over a white floor, seen from aslant."""

    def put(material):
        stage.environment(stage.picture("Six", stage.six_coloured_sky()), 0.5)
        ball = stage.object_of("Ball", stage.icosphere(4), material, (0.0, 0.0, 1.3))
        stage.object_of("Floor", stage.grid(40, 3.0), stage.diffuse("White", (0.8, 0.8, 0.8)))
        stage.top_camera(5.0, RESOLUTION)
        camera = blender.context.scene.camera
        camera.location, camera.rotation_euler = (0.0, -8.0, 6.0), (radians(57.0), 0.0, 0.0)
        return ball

    return put


@pytest.fixture
def compared(blender, stage, tmp_path):
    """Bake, and compare EEVEE's picture with Cycles': relative RMS, and by how much EEVEE's is brighter."""

    def compare():
        scene = blender.context.scene
        scene.cycles.max_bounces = 6
        assert blender.ops.prt.bake(mode="INTERREFLECTED", bounces=5, samples=256) == {"FINISHED"}
        truth = stage.render(tmp_path / "truth.exr", "CYCLES", 64)
        shown = stage.render(tmp_path / "shown.exr")
        there = np.minimum(truth[..., 3], shown[..., 3]) > 0.99
        truth, shown = truth[there][:, :3], shown[there][:, :3]
        return np.sqrt(((shown - truth) ** 2).mean() / (truth**2).mean()), shown.mean() / truth.mean()

    return compare


def principled(blender, **inputs):
    """A material of one Principled BSDF."""
    from headless import use_nodes

    material = blender.data.materials.new("Principled")
    use_nodes(material)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = GOLD
    for name, value in inputs.items():
        shader.inputs[name.replace("_", " ")].default_value = value
    return material


def lamp(blender, kind, energy):
    """A lamp that shines on the ball from the left."""
    light = blender.data.lights.new("Lamp", kind)
    light.energy = energy
    ob = blender.data.objects.new("Lamp", light)
    ob.location, ob.rotation_euler = (-2.0, -2.0, 4.0), (radians(35.0), 0.0, radians(-45.0))
    blender.context.scene.collection.objects.link(ob)
    return ob


SURFACES: dict[str, tuple[dict[str, Any], float]] = {
    "plastic": ({"Roughness": 0.4}, 0.05),
    "metal": ({"Roughness": 0.6, "Metallic": 1.0}, 0.08),
    "half a metal": ({"Roughness": 0.6, "Metallic": 0.5}, 0.09),
    "coat": ({"Roughness": 0.6, "Coat_Weight": 1.0}, 0.06),
    "glow": ({"Emission_Strength": 0.3, "Emission_Color": (0.2, 0.6, 1.0, 1.0)}, 0.08),
    "no gloss": ({"Specular_IOR_Level": 0.0}, 0.06),
}


@pytest.mark.parametrize("surface", SURFACES)
def test_surface_agrees_with_cycles(blender, over_a_floor, compared, surface):
    inputs, most = SURFACES[surface]
    over_a_floor(principled(blender, **inputs))
    error, ratio = compared()
    assert error < most
    assert abs(ratio - 1.0) < 0.05


LET_THROUGH: dict[str, tuple[dict[str, Any], float]] = {
    "alpha": ({"Alpha": 0.5, "Roughness": 0.5}, 0.07),
    "hardly any alpha": ({"Alpha": 0.2, "Roughness": 0.5}, 0.05),
    "transmission": ({"Transmission_Weight": 1.0, "Roughness": 0.3, "IOR": 1.3}, 0.18),
    "half transmission": ({"Transmission_Weight": 0.5, "Roughness": 0.5}, 0.08),
    "subsurface": ({"Subsurface_Weight": 1.0, "Subsurface_Scale": 0.05}, 0.07),
    "sheen": ({"Sheen_Weight": 1.0}, 0.08),
}


@pytest.mark.parametrize(
    "surface", [each if each == "alpha" else pytest.param(each, marks=pytest.mark.slow) for each in LET_THROUGH]
)
def test_what_lets_light_through_agrees_with_cycles(blender, over_a_floor, compared, surface):
    """Alpha; glass, whose EEVEE refracts the sky and no floor, and which is the farthest; and what the bake takes for matte: skin, cloth.

    EEVEE draws lots for what is seen through, sample by sample.
    """
    inputs, most = LET_THROUGH[surface]
    over_a_floor(principled(blender, **inputs))
    blender.context.scene.eevee.taa_render_samples = 32
    error, ratio = compared()
    print(f"{surface}: {error:.3f} from Cycles, {ratio:.3f} times as bright")
    assert error < most
    assert abs(ratio - 1.0) < 0.05


@pytest.mark.parametrize("fresnel", ["F82", "PHYSICAL_CONDUCTOR"])
def test_metallic_bsdf_agrees_with_cycles(blender, stage, over_a_floor, compared, fresnel):
    """By a colour, and by indices of refraction, as copper has them."""
    material = stage.diffuse("Copper")
    tree = material.node_tree
    shader = tree.nodes.new("ShaderNodeBsdfMetallic")
    shader.inputs["Roughness"].default_value, shader.inputs["Base Color"].default_value = 0.6, GOLD
    shader.fresnel_type = fresnel
    if fresnel == "PHYSICAL_CONDUCTOR":
        for name, value in {"IOR": (0.27, 0.68, 1.32), "Extinction": (3.61, 2.6, 2.29)}.items():
            shader.inputs[name].default_value = value
    tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    over_a_floor(material)
    error, ratio = compared()
    assert error < 0.08
    assert abs(ratio - 1.0) < 0.05


@pytest.mark.parametrize(("kind", "energy"), [("SUN", 2.0), ("POINT", 300.0), ("AREA", 300.0)])
def test_lamps_light_relit_surfaces(blender, over_a_floor, compared, kind, energy):
    """With shadows, and no light of the sky twice."""
    over_a_floor(principled(blender, Roughness=1.0, Specular_IOR_Level=0.0))
    lamp(blender, kind, energy).data.use_shadow = True
    error, ratio = compared()
    assert error < 0.08
    assert abs(ratio - 1.0) < 0.05


def bent(material, shader, amount):
    """Bend a shader's normals in soft waves. EEVEE's Bump is another than Cycles' where triangles are small; this is the same in both.

    Noise would do, but without a graphics card EEVEE compiles its loops for minutes.
    """
    tree = material.node_tree
    place = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    own = tree.nodes.new("ShaderNodeNewGeometry").outputs["Normal"]
    aslant, waves, bent, unit = (tree.nodes.new("ShaderNodeVectorMath") for _ in range(4))
    operations = ("CROSS_PRODUCT", "SINE", "MULTIPLY_ADD", "NORMALIZE")
    for node, operation in zip((aslant, waves, bent, unit), operations, strict=True):
        node.operation = operation
    aslant.inputs[1].default_value, bent.inputs[1].default_value = (9.0, 7.0, 11.0), (amount,) * 3
    for source, entry in (
        (place, aslant.inputs[0]),
        (aslant.outputs[0], waves.inputs[0]),
        (waves.outputs[0], bent.inputs[0]),
        (own, bent.inputs[2]),
        (bent.outputs[0], unit.inputs[0]),
        (unit.outputs[0], shader.inputs["Normal"]),
    ):
        tree.links.new(source, entry)


@pytest.mark.parametrize("kind", ["Diffuse", "Principled"])
def test_normal_detail_acts_on_baked_light(blender, part, over_a_floor, compared, stage, tmp_path, kind):
    """With it EEVEE's picture is nearer to Cycles' than without. What is left is noise, and normals bent by more than a gradient says."""
    material = principled(blender, Specular_IOR_Level=0.0) if kind == "Principled" else stage.diffuse("Bent", GOLD[:3])
    over_a_floor(material)
    for one in (material, blender.data.materials["White"]):
        bent(one, next(node for node in one.node_tree.nodes if "Bsdf" in node.bl_idname), 0.25)
    error, _ = compared()
    truth = stage.read_exr(tmp_path / "truth.exr")
    stage.without_normal_detail()
    plain = stage.render(tmp_path / "plain.exr")
    there = np.minimum(truth[..., 3], plain[..., 3]) > 0.99
    without = np.sqrt(((plain - truth)[there][:, :3] ** 2).mean() / (truth[there][:, :3] ** 2).mean())
    assert error < 0.08 and error < 0.85 * without


def test_shaders_in_groups_show_alike(blender, part, over_a_floor, stage, tmp_path):
    """A metal mixed into a group, its roughness fed from outside, as the same metal without a group."""
    ball = over_a_floor(principled(blender, Metallic=1.0, Roughness=0.6))
    assert blender.ops.prt.bake(mode="SHADOWED", samples=64) == {"FINISHED"}
    plain = stage.render(tmp_path / "plain.exr")
    part("relight_material").remove_from_material(ball.data.materials[0])
    ball.data.materials[0] = grouped(blender)
    part("shading").add_shading([ball])
    np.testing.assert_allclose(stage.render(tmp_path / "grouped.exr"), plain, atol=2e-2)
    part("shading").remove_shading(blender.context.scene.objects[:])
    assert not [tree.name for tree in blender.data.node_groups if "prt_part" in tree]


def grouped(blender):
    """A material of a group that mixes two equal metals."""
    material = principled(blender)
    tree = blender.data.node_groups.new("Metals", "ShaderNodeTree")
    tree.interface.new_socket("How Rough", in_out="INPUT", socket_type="NodeSocketFloat")
    tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    entry, mix, output = (tree.nodes.new(kind) for kind in ("NodeGroupInput", "ShaderNodeMixShader", "NodeGroupOutput"))
    for number in (1, 2):
        shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
        shader.inputs["Base Color"].default_value, shader.inputs["Metallic"].default_value = GOLD, 1.0
        tree.links.new(entry.outputs[0], shader.inputs["Roughness"])
        tree.links.new(shader.outputs[0], mix.inputs[number])
    tree.links.new(mix.outputs[0], output.inputs[0])
    nodes = material.node_tree.nodes
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs["How Rough"].default_value = 0.6
    material.node_tree.links.new(group.outputs[0], nodes["Material Output"].inputs["Surface"])
    return material


def test_no_light_of_the_sky_leaks_into_a_closed_room(blender, stage, scene, tmp_path):
    """A lamp that is there, but dark: nothing of EEVEE's own sky is left, neither diffuse nor as gloss."""
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    room = stage.object_of("Room", stage.cube(4.0), principled(blender, Roughness=0.5))
    room.data.flip_normals()
    lamp(blender, "POINT", 0.0).location = (0.0, 0.0, 1.0)
    stage.top_camera(1.0)
    scene.camera.location = (0.0, 0.0, 1.5)
    assert blender.ops.prt.bake(mode="INTERREFLECTED", samples=64) == {"FINISHED"}
    assert stage.render(tmp_path / "room.exr")[..., :3].max() < 5e-3


def test_eevees_own_sun_goes_and_comes_back(blender, stage, scene):
    """It is in the baked light; Remove gives it back."""
    world, _ = stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    world.sun_threshold = 7.0
    stage.object_of("Cube", stage.cube(), stage.diffuse())
    for _ in range(2):
        blender.ops.prt.bake(mode="UNSHADOWED")
        assert world.sun_threshold == 0.0
    blender.ops.prt.remove()
    assert world.sun_threshold == 7.0


def test_what_glows_is_said_to_light_nothing(blender, part, scene, stage):
    """Counted, and only of what does: white of strength 0 emits nothing, nor does black."""
    glowing = {
        "Glow": (1.0, (1.0, 0.5, 0.2, 1.0)),
        "Off": (0.0, (1.0, 1.0, 1.0, 1.0)),
        "Black": (1.0, (0.0, 0.0, 0.0, 1.0)),
    }
    for number, (name, (strength, colour)) in enumerate(glowing.items()):
        material = principled(blender, Emission_Strength=strength, Emission_Color=colour)
        material.name = name
        stage.object_of(name, stage.cube(), material, (3.0 * number, 0.0, 0.0))
    said = [notice for notice in part("shading").add_shading(scene.objects[:]) if "emits light" in notice.kind.one]
    assert [notice.name for notice in said] == ["Glow"]


def tilted_by(material, kind):
    """Tilt the normal of a flat, horizontal surface towards -x, by a Normal Map or a Bump."""
    tree = material.node_tree
    shader = next(node for node in tree.nodes if "Bsdf" in node.bl_idname)
    node = tree.nodes.new(f"ShaderNode{kind}")
    if kind == "NormalMap":
        node.space = "WORLD"
        node.inputs["Color"].default_value = (*((np.array((-sin(TILT), 0.0, cos(TILT))) + 1.0) / 2.0).tolist(), 1.0)
    else:
        place, split, slope = (tree.nodes.new(f"ShaderNode{one}") for one in ("TexCoord", "SeparateXYZ", "Math"))
        slope.operation, slope.inputs[1].default_value = "MULTIPLY", tan(TILT)
        tree.links.new(place.outputs["Object"], split.inputs[0])
        tree.links.new(split.outputs[0], slope.inputs[0])
        tree.links.new(slope.outputs[0], node.inputs["Height"])
        node.inputs["Distance"].default_value = 1.0
    tree.links.new(node.outputs[0], shader.inputs["Normal"])


@pytest.fixture
def sheet(blender, stage):
    """Put a sheet of a material under the sky and a sun, seen from above."""

    def put(material):
        stage.environment(stage.picture("Six", stage.six_coloured_sky()), 0.5)
        lamp(blender, "SUN", 0.0)
        stage.top_camera(1.0, 8)
        return stage.object_of("Sheet", stage.grid(1, 2.0), material)

    return put


@pytest.fixture
def colour_of_sheet(blender, stage, tmp_path):
    """Its colour in an engine, or what a sun of some strength adds to it. It is the same everywhere; the median leaves out where EEVEE's
    Bump, which compares neighbouring pixels, finds two triangles.
    """

    def measure(engine, energy):
        frames = []
        for strength in (0.0, energy)[: 1 + bool(energy)]:
            blender.data.objects["Lamp"].data.energy = strength
            frame = stage.render(tmp_path / "sheet.exr", engine, 1024)
            frames.append(np.median(frame[..., :3], axis=(0, 1)))
        return frames[-1] - frames[0] if energy else frames[0]

    return measure


BENT = {
    "soft light": ({"Specular_IOR_Level": 0.0, "Roughness": 1.0}, 0.0, 0.08),
    "lamps": ({"Specular_IOR_Level": 0.0, "Roughness": 1.0}, 3.0, 0.06),
    "gloss": ({"Metallic": 1.0, "Roughness": 0.5}, 0.0, 0.15),
}


@pytest.mark.parametrize("what", BENT)
@pytest.mark.parametrize("kind", ["NormalMap", pytest.param("Bump", marks=pytest.mark.slow)])
def test_normal_maps_and_bumps_bend(blender, sheet, colour_of_sheet, kind, what):
    """They change what EEVEE shows as Cycles' picture changes where the sheet itself is turned, which knows no map and no bump."""
    inputs, energy, most = BENT[what]
    material = principled(blender, Base_Color=(0.8, 0.8, 0.8, 1.0), **inputs)
    ob = sheet(material)
    assert blender.ops.prt.bake(mode="UNSHADOWED", lamps="NONE") == {"FINISHED"}
    flat, turned = colour_of_sheet("EEVEE", energy), -colour_of_sheet("CYCLES", energy)
    ob.rotation_euler.y = -TILT
    turned += colour_of_sheet("CYCLES", energy)
    ob.rotation_euler.y = 0.0
    tilted_by(material, kind)
    blender.context.view_layer.update()
    bent = colour_of_sheet("EEVEE", energy) - flat
    wrong = np.linalg.norm(bent - turned) / np.linalg.norm(turned)
    print(f"{kind}, {what}: {bent} for {turned}, off by {wrong:.3f}")
    assert wrong < most
