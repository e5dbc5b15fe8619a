# SPDX-License-Identifier: GPL-3.0-or-later
"""A browser, and a scene with all that pages show."""

import numpy as np
import pytest

from tests.web.browser import Browser
from tests.web.views import HEIGHT, WIDTH


@pytest.fixture(scope="module")
def browser():
    found = Browser()
    found.skip_if_missing()
    return found


def look_from(blender, scene, place, turn):
    """A camera there, and frames of the tests' size."""
    camera = blender.data.objects.new("Camera", blender.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = place, turn
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT


def matte(blender, stage, name, colour):
    """A Principled BSDF without gloss: what glTF knows."""
    material = blender.data.materials.new(name)
    stage.use_nodes(material)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def checker(blender, stage):
    """A matte Principled BSDF coloured by a picture of sixteen squares."""
    squares = np.indices((4, 4)).sum(axis=0) % 2
    image = blender.data.images.new("Squares", 4, 4)
    rgba = np.ones((4, 4, 4), dtype=np.float32)
    rgba[..., :3] = np.where(squares[..., None], (0.9, 0.5, 0.2), (0.2, 0.3, 0.8))
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    material = matte(blender, stage, "Squares", (1.0, 1.0, 1.0))
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = image, "Closest"
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material


@pytest.fixture
def scene_of_all(blender, scene, stage):
    """A ball on a checked floor, and a box with axes of its own, turned and scaled; a camera, a turned sky."""
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.4)
    mapping.inputs["Rotation"].default_value = (0.3, -0.5, 1.3)
    ball = stage.object_of("Ball", stage.icosphere(4), matte(blender, stage, "Clay", (0.8, 0.5, 0.2)), (0, 0, 1))
    floor = stage.object_of("Floor", stage.grid(60, 3.0), checker(blender, stage))
    lay_out(floor.data, (0, 1), 3.0)
    box = stage.object_of("Box", stage.cube(0.8), matte(blender, stage, "Other", (0.3, 0.6, 0.5)), (1.6, -0.9, 0.8))
    box.rotation_euler, box.scale = (0.4, 0.3, 0.8), (1.0, 0.7, 1.4)
    box.prt.space = "OBJECT"
    look_from(blender, scene, (4.0, -7.0, 4.2), (1.05, 0.0, 0.52))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps="NONE")
    assert ball.data.attributes.get("_PRT_0")
    return scene


@pytest.fixture
def glossy_scene(blender, scene, stage):
    """Three balls on a floor under a photographic sky: metal, a polished one, and one whose gloss and dents are pictures."""
    stage.environment(blender.data.images.load(str(stage.headless.studio_hdri("forest"))))
    kinds = {"Metal": (1.0, 0.3), "Polished": (0.0, 0.25), "Dented": (0.0, 0.4), "Floor": (0.0, 0.7)}
    materials = {name: matte(blender, stage, name, (0.8, 0.5, 0.2)) for name in kinds}
    for name, (metallic, roughness) in kinds.items():
        inputs = materials[name].node_tree.nodes["Principled BSDF"].inputs
        inputs["Specular IOR Level"].default_value = 0.5
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, roughness
    dent(blender, materials["Dented"])
    for x, name in enumerate(("Metal", "Polished", "Dented")):
        ball = stage.object_of(name, stage.icosphere(5), materials[name], (2.4 * x - 2.4, 0, 1))
        if name == "Dented":
            lay_out(ball.data)
    stage.object_of("Floor", stage.grid(60, 5.0), materials["Floor"])
    look_from(blender, scene, (1.0, -11.0, 3.6), (1.32, 0.0, 0.09))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps="NONE")
    return scene


def lay_out(mesh, axes=(0, 2), size=1.0):
    """Texture coordinates by the place along two axes, once from -size to size."""
    mesh.uv_layers.new()
    places = np.array([mesh.vertices[loop.vertex_index].co[:] for loop in mesh.loops])[:, axes] * (0.5 / size) + 0.5
    mesh.uv_layers[0].data.foreach_set("uv", places.ravel())


def dent(blender, material):
    """A picture of waves for the normals, and one of stripes for the roughness."""
    tree = material.node_tree
    x, y = np.meshgrid(*[np.linspace(0, 6 * np.pi, 128, endpoint=False)] * 2)
    normals = np.stack([0.4 * np.sin(x), 0.25 * np.cos(y), np.ones_like(x)], axis=-1)
    normals = 0.5 + 0.5 * normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    stripes = np.repeat((0.25 + 0.5 * (np.sin(x) > 0.0))[..., None], 3, axis=-1)
    pictures = []
    for name, numbers in (("Waves", normals), ("Stripes", stripes)):
        image = blender.data.images.new(name, 128, 128)
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(np.concatenate([numbers, np.ones((128, 128, 1))], axis=-1).astype(np.float32).ravel())
        image.pack()
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        pictures.append(node)
    bent, shader = tree.nodes.new("ShaderNodeNormalMap"), tree.nodes["Principled BSDF"]
    tree.links.new(pictures[0].outputs["Color"], bent.inputs["Color"])
    tree.links.new(bent.outputs["Normal"], shader.inputs["Normal"])
    tree.links.new(pictures[1].outputs["Color"], shader.inputs["Roughness"])
