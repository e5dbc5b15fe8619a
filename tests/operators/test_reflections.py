# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.add_reflections`: a metal floor mirrors what is relit, matte surfaces stay as they are, and all can be set back."""

import numpy as np
import pytest

SETTINGS = (
    "use_raytracing",
    "ray_tracing_method",
    "use_fast_gi",
    "fast_gi_method",
    "ray_tracing_options.trace_max_roughness",
)


@pytest.fixture
def hall(blender, stage, tmp_path):
    """A red ball over a floor of metal, baked; looks at it: (rows, columns, 4) by a function."""
    stage.environment(stage.picture("White", np.ones((16, 32, 3))))
    metal = stage.diffuse("Metal")
    tree = metal.node_tree
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for name, value in (("Base Color", (0.9, 0.9, 0.9, 1.0)), ("Metallic", 1.0), ("Roughness", 0.1)):
        shader.inputs[name].default_value = value
    tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    stage.object_of("Floor", stage.grid(24, 1.5), metal)
    stage.object_of("Ball", stage.icosphere(4, 0.6), stage.diffuse("Red", (0.9, 0.05, 0.05)), (0.0, 0.3, 0.62))
    camera = stage.top_camera(scale=3.2)
    camera.location, camera.rotation_euler = (0.0, -8.0, 2.4), (1.3, 0.0, 0.0)
    blender.context.scene.cycles.use_adaptive_sampling = False
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=128)

    def look(engine="EEVEE"):
        blender.context.scene.eevee.taa_render_samples = 16
        return stage.render(tmp_path / "hall.exr", engine, samples=128)

    return look


def settings(scene):
    return {path: scene.eevee.path_resolve(path) for path in SETTINGS}


def error(picture, truth, where):
    return np.linalg.norm((picture - truth)[where][:, :3]) / np.linalg.norm(truth[where][:, :3])


def test_a_metal_floor_mirrors_what_is_relit(blender, scene, hall):
    """It comes closer to Cycles, and the ball stays what it is."""
    truth, before = hall("CYCLES"), hall()
    solid = (truth[..., 3] > 0.99) & (before[..., 3] > 0.99)
    floor = blender.data.objects["Floor"]
    floor.hide_render = True
    ball = hall()[..., 3] > 0.99
    floor.hide_render = False
    assert blender.ops.prt.add_reflections() == {"FINISHED"}
    after = hall()
    found = [error(picture, truth, solid) for picture in (before, after)]
    print(f"from Cycles: {found[0]:.3f} without, {found[1]:.3f} with")  # pytest shows it on failure, or with -s
    assert found[1] < 0.85 * found[0]
    assert 100 < ball.sum() < 0.5 * solid.sum()
    assert error(after, before, ball) < 0.01


def test_settings_come_back(blender, scene, hall):
    """As they were, but for what someone has changed since."""
    scene.eevee.use_fast_gi = False
    before = settings(scene)
    blender.ops.prt.add_reflections()
    assert settings(scene) != before and scene.eevee.fast_gi_method == "AMBIENT_OCCLUSION_ONLY"
    blender.ops.prt.add_reflections()  # again: what was before is not forgotten
    assert blender.ops.prt.remove_reflections() == {"FINISHED"}
    assert settings(scene) == before and not [key for key in dict(scene) if "reflections" in key]
    blender.ops.prt.add_reflections()
    scene.eevee.use_raytracing = False
    blender.ops.prt.remove_reflections()
    assert settings(scene) == before
    blender.ops.prt.add_reflections()
    blender.ops.prt.remove()
    assert settings(scene) == before
    assert not blender.ops.prt.remove_reflections.poll() and not blender.ops.prt.add_reflections.poll()
