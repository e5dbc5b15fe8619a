# SPDX-License-Identifier: GPL-3.0-or-later
"""Has Blender evaluate the sky of a world, whatever its nodes: a panorama of any node graph.

Cycles' bake of the type Environment looks from each vertex of a mesh along its position, and so evaluates a world along
any set of directions, without a camera, a file or a trace in the render result. A copy of the world hangs over a scene of
its own (see `cycles_scene`).

In the copy, what the light follows by itself is neutral: the Mapping node that turns it is bypassed, the strength is one.
Light Path nodes answer as they do for light that falls on matte surfaces: worlds may show the camera something else.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from ...core.arrays import Float32
from ...core.errors import LightError
from ...core.sky.texel_means import Radiance, equirect_means
from ..blender.cycles_scene import cycles_scene, selected_alone
from ..blender.light_path import answer_light_path
from ..blender.nodes import feeding_socket, has_loop
from ..mesh.meshes import layer_array
from .sky import Sky, output_of

_NAME = "PRT Panorama"
_LAYER = "prt_radiance"


def panorama(sky: Sky, height: int = 512) -> Float32:
    """(height, 2 height, 3) linear radiance, row 0 at the bottom, unturned and at strength 1 if these are followed.

    Raises:
        LightError: if Blender cannot evaluate the world now.
    """
    with _alone(sky) as radiance:
        return equirect_means(radiance, height)


@contextmanager
def _alone(sky: Sky) -> Iterator[Radiance]:
    """The radiance of a sky along directions (N, 3); what it takes is gone afterwards."""
    groups = list[bpy.types.NodeTree]()
    if not hasattr(bpy.context.scene, "cycles"):
        raise LightError(
            f"World '{sky.world.name}' is evaluated by Cycles, which is disabled: enable it in Preferences."
        )
    world = sky.world
    if world.node_tree and has_loop(world.node_tree):
        raise LightError(f"Nodes of world '{world.name}' feed each other in a circle: unlink them.")
    if not world.is_evaluated:
        world = world.evaluated_get(bpy.context.evaluated_depsgraph_get())
    world = world.copy()  # as it is at this frame
    try:
        _neutralise(world, sky, groups)
        with cycles_scene(_NAME) as scene:
            scene.world = world
            scene.cycles.use_denoising = False
            yield lambda directions: _evaluated(scene, directions)
    finally:
        bpy.data.worlds.remove(world)
        for group in groups:
            bpy.data.node_groups.remove(group)


def _evaluated(scene: bpy.types.Scene, directions: Float32) -> Float32:
    """(N, 3) radiance along directions (N, 3), neighbours of which are next to each other: three make a triangle."""
    count = len(directions)
    corners = np.pad(directions, ((0, -count % 3), (0, 0)), mode="edge")
    mesh = bpy.data.meshes.new(_NAME)
    try:
        mesh.vertices.add(len(corners))
        mesh.vertices.foreach_set("co", corners.ravel())
        mesh.loops.add(len(corners))
        mesh.loops.foreach_set("vertex_index", np.arange(len(corners), dtype=np.int32))
        mesh.polygons.add(len(corners) // 3)
        mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
        mesh.update()
        mesh.attributes.new(_LAYER, "FLOAT_COLOR", "CORNER")
        mesh.color_attributes.active_color_name = _LAYER
        with selected_alone(scene, mesh):
            bpy.ops.object.bake(type="ENVIRONMENT", target="VERTEX_COLORS", use_clear=True)
    except RuntimeError as error:  # the operator refuses
        raise LightError(f"World '{scene.world.name}' cannot be evaluated by Cycles now: {error}") from error
    else:
        return layer_array(mesh, _LAYER, "color", 4)[:count, :3]
    finally:
        bpy.data.meshes.remove(mesh)


def _neutralise(world: bpy.types.World, sky: Sky, groups: list[bpy.types.NodeTree]) -> None:
    """Take what is followed out of a copy of the sky's world; the copies of groups that it gets are noted."""
    world.animation_data_clear()
    for name in [name for name in world.keys() if name.startswith("prt_")]:  # noqa: SIM118 - an ID is no dict
        del world[name]  # handlers look after worlds with a light
    world.cycles.sampling_method = "NONE"  # no lamps are sampled: saves the map of where the sky is bright
    world.cycles_visibility.camera = world.cycles_visibility.diffuse
    output = output_of(world)
    if output is None:
        return
    tree = world.node_tree
    tree.animation_data_clear()
    for other in [node for node in tree.nodes if node.bl_idname == output.bl_idname and node != output]:
        tree.nodes.remove(other)
    output.target = "ALL"
    for link in list(output.inputs["Volume"].links):
        tree.links.remove(link)
    if sky.mapping:
        _bypass(tree, tree.nodes[sky.mapping.name])
    if sky.sun:
        tree.nodes[sky.sun.name].sun_rotation = 0.0
    surface = feeding_socket(output.inputs["Surface"])
    if sky.strength and surface:
        strength = surface.node.inputs["Strength"]
        for link in list(strength.links):
            tree.links.remove(link)
        strength.default_value = 1.0
    answer_light_path(tree, groups)


def _bypass(tree: bpy.types.NodeTree, mapping: bpy.types.Node) -> None:
    source = feeding_socket(mapping.inputs["Vector"])
    for link in list(mapping.outputs[0].links):
        tree.links.new(source, link.to_socket)
