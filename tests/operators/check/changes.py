# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the changes that people make to an object between two bakes, and lists the causes that a check finds."""

NOTHING: set[str] = set()
MOVED, OTHERS, GEOMETRY, COLOURS = {"MOVED"}, {"OTHERS"}, {"GEOMETRY"}, {"COLOURS"}
EVERYONE = ("Floor", "Ball", "Cube")


def select(blender, *objects):
    for ob in blender.data.objects:
        ob.select_set(ob in objects)


def shift(ob):
    ob.location.x += 0.1


def turn(ob):
    ob.rotation_euler.z += 0.3


def push_vertex(ob):
    ob.data.vertices[0].co.z += 0.01
    ob.data.update()


def sharpen(ob):
    """Other shading normals, the same surface."""
    ob.data.polygons[0].use_smooth = not ob.data.polygons[0].use_smooth
    ob.data.update()


def bend_normals(ob):
    ob.data.normals_split_custom_set([(0.6, 0.0, 0.8)] * len(ob.data.loops))


def paint(ob):
    """Another colour of its material."""
    nodes = ob.data.materials[0].node_tree.nodes
    next(n for n in nodes if n.bl_idname == "ShaderNodeBsdfDiffuse").inputs["Color"].default_value = (0, 1, 0, 1)
