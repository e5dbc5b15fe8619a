# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how much surface a bake finds in a scene, and how much light it leaves on objects."""

import numpy as np


def extra_area(part, bpy, ground):
    """World-space area of all triangles beside the ground's."""
    bpy.context.view_layer.update()
    plan = part("read").read_bake(bpy.context, [ground])
    a, b, c = (plan.scene.occluders.vertices[plan.scene.occluders.triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 - 1.0


def shadow(part, blender, *objects):
    """Mean shadowed T_0 of the objects, as a share of the open sky's."""
    blender.context.view_layer.update()
    problem = part("problem")
    plan = part("read").read_bake(blender.context, list(objects), problem.BakeSettings("SHADOWED", 256))
    transport = part("bake").bake(plan.problem).transport
    first = np.concatenate([transport[one.group][:, 0] for one in plan.objects])
    return float(first.mean() / 0.28209479)
