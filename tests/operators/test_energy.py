# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.add_energy_compensation`: rough metal returns what theory and Cycles' multiscatter GGX say, and goes back."""

import numpy as np
import pytest

from prt_addon.core.microfacet import compensation
from prt_addon.core.microfacet.albedo import by_quadrature
from prt_addon.core.microfacet.table import average_albedo

PIXELS = 24
WHITE, COPPER = (1.0, 1.0, 1.0), (0.95, 0.64, 0.54)


@pytest.fixture
def furnace(blender, stage, tmp_path):
    """A sphere of a Glossy BSDF under a sky of 1, its shader, and a look at it: (pixels, 3), with the cosine at each."""
    shader, shown, mu = stage.furnace(rim=0.3, pixels=PIXELS)
    shader.distribution = "GGX"
    blender.data.objects["Sphere"].select_set(True)

    def look(engine):
        blender.context.scene.eevee.taa_render_samples = 16
        return stage.render(tmp_path / "sphere.exr", engine, samples=128)[shown][:, :3]

    return shader, look, mu


def theory(colour, mu, roughness):
    """(pixels, 3) light of all bounces; and of one."""
    albedo = by_quadrature(mu, roughness).white[:, None]
    first = np.array(colour) * albedo
    return first + (1.0 - albedo) * compensation.bounce_colour(colour, average_albedo(roughness)), first


@pytest.mark.parametrize(("engine", "tolerance"), [("EEVEE", 0.03), ("CYCLES", 0.01)])
def test_spheres_return_what_they_lost(blender, furnace, engine, tolerance):
    """A white one all light, a coloured one the series of its bounces; EEVEE's own share of it is 1 to 2 % too low."""
    shader, look, mu = furnace
    shader.inputs["Color"].default_value, shader.inputs["Roughness"].default_value = (*WHITE, 1.0), 0.8
    lossy = look(engine).mean()
    assert lossy == pytest.approx(theory(WHITE, mu, 0.8)[1].mean(), abs=tolerance) and lossy < 0.7
    assert blender.ops.prt.add_energy_compensation() == {"FINISHED"}
    entries = {entry.name: entry for entry in shader.inputs["Color"].links[0].from_node.inputs}
    for colour, roughness in ((WHITE, 0.8), (COPPER, 0.8), (COPPER, 0.5)):
        entries["Color"].default_value, entries["Roughness"].default_value = (*colour, 1.0), roughness
        found, (expected, _) = look(engine), theory(colour, mu, roughness)
        print(engine, colour, roughness, found.mean(axis=0), expected.mean(axis=0))  # pytest shows it on failure
        np.testing.assert_allclose(found.mean(axis=0), expected.mean(axis=0), atol=tolerance)


def test_nodes_go_back(blender, furnace):
    """The numbers, what fed them, and no group is left; a second press adds none, and other types get none."""
    shader, *_ = furnace
    tree = shader.id_data
    colour = tree.nodes.new("ShaderNodeRGB")
    tree.links.new(colour.outputs[0], shader.inputs["Color"])
    shader.inputs["Roughness"].default_value = 0.3
    before = [(node.name, node.bl_idname) for node in tree.nodes]
    blender.ops.prt.add_energy_compensation()
    assert blender.ops.prt.add_energy_compensation() == {"CANCELLED"}
    group = shader.inputs["Color"].links[0].from_node
    assert group.inputs["Color"].links[0].from_node == colour
    group.inputs["Roughness"].default_value = 0.6  # edited meanwhile
    assert blender.ops.prt.remove_energy_compensation() == {"FINISHED"}
    assert [(node.name, node.bl_idname) for node in tree.nodes] == before
    assert shader.inputs["Color"].links[0].from_node == colour
    assert shader.inputs["Roughness"].default_value == pytest.approx(0.6) and not shader.inputs["Roughness"].is_linked
    assert not [tree for tree in blender.data.node_groups if "Energy" in tree.name]
    shader.distribution = "MULTI_GGX"
    assert blender.ops.prt.add_energy_compensation() == {"CANCELLED"}
