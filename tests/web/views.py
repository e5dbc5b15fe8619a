# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the same view, by EEVEE and by others, compared."""

import numpy as np

WIDTH, HEIGHT = 320, 180


def eevee(stage, scene, path):
    """Its frame of the scene's view over nothing, (H, W, 4), without smoothing beyond the pixel."""
    scene.render.film_transparent, scene.render.filter_size = True, 0.01
    scene.eevee.taa_render_samples = 1
    return stage.render(path)


def without_normal_detail():
    """Have EEVEE leave the soft light as it is where normals are bent, as pages do: they bend that of suns and gloss alone."""
    import bpy

    for detail in (tree for tree in bpy.data.node_groups if tree.name == "PRT Detail"):
        entry, end = (
            next(node for node in detail.nodes if node.bl_idname == f"NodeGroup{one}") for one in ("Input", "Output")
        )
        detail.links.new(entry.outputs["Shading"], end.inputs["Shading"])


def relative_rms(found, wanted):
    difference = found[:, :3] - wanted[:, :3]
    return np.sqrt((difference**2).mean() / (wanted[:, :3] ** 2).mean())
