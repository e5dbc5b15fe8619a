# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks the relight group into materials beside the user's own nodes, and takes it out again.

The group feeds a Material Output whose target is EEVEE. The user's own output, links and nodes are not touched:
Cycles still renders them, and removing our two nodes restores the material.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import bpy

from ...core.errors import MeshError
from ...core.notices import Kind, Notice
from ..blender.libraries import check_local, is_local
from ..blender.nodes import HAD_NO_NODES, feeding_socket, nodes_are_on, turn_nodes
from ..light.lamps import follow_receivers
from ..material.colour_nodes import add_part, remove_parts
from ..material.reading import OURS, PART, Constant, has_surface, read_material, user_output
from ..mesh.carrier import transport_mesh
from ..mesh.layers import has_backs, is_baked
from .relight_group import (
    check_version,
    is_newer,
    is_relight_group,
    is_relit_by_newer,
    relight_group,
    remove_unused_group,
)
from .slots import ROOM, ROOM_WITH_BACKS, attributes_read
from .surface_nodes import build_surface, follow_numbers, sockets_of, structure, write

OUTPUT = "PRT Output"
MADE = "prt_made"
"""Custom property of a material that we made for an object that had none."""
_SURFACE = "prt_surface"
"""Custom property of our group node: the structure of the surface that is relit, or that it is matte."""
_MATTE = "matte"
_SLOT_ADDED = "prt_slot_added"
VIEWPORT = "prt_viewport_colour"
"""Custom property of the output that we add for Cycles to a material that had no nodes."""


_FOREIGN = Kind(
    "Material {name} is linked from a library, or overrides it, and is not relit: make it local to relight it.",
    "{count} materials are linked from libraries, or override them, and are not relit: make them local to relight them: {names}.",
)
_NEWER = Kind(
    "Material {name} is relit by a newer version of PRT Relight, and stays as it is: use a newer version of the extension here.",
    "{count} materials are relit by a newer version of PRT Relight, and stay as they are: {names}.",
)
_LIGHTLESS = Kind(
    "Material {name} reflects no light: EEVEE goes on showing it as it is.",
    "{count} materials reflect no light: EEVEE goes on showing them as they are: {names}.",
    "INFO",
)
_GLOWS = Kind(
    "Material {name} emits light: it glows, but lights nothing around it in the bake. Put lamps where it shines.",
    "{count} materials emit light: they glow, but light nothing around them in the bake. Put lamps where they shine: {names}.",
    "INFO",
)
_TOO_MANY_ATTRIBUTES = Kind(
    "Material {name} reads {count} attributes of the mesh (UV maps, colours, tangents). EEVEE takes 14 in all, and the "
    "transport needs nine: it is not relit. Let it read {most} at most.",
    "{count} materials read more attributes of their meshes (UV maps, colours, tangents) than EEVEE takes beside the "
    "transport's nine, and are not relit: {names}.",
)
_NO_BACKS = Kind(
    "Material {name} reads {count} attributes of the mesh (UV maps, colours, tangents), which leaves EEVEE no room for the three of "
    "backs: these show the light of the fronts. Let it read {most} at most.",
    "{count} materials read too many attributes of their meshes (UV maps, colours, tangents) beside the three of backs, which show "
    "the light of the fronts: {names}.",
    "INFO",
)
_GREY = Kind(
    "Material {name}: {why}; it is relit in grey.",
    "{count} materials have surfaces that cannot be read, and are relit in grey: {names}.",
)


def materials_of(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Material]:
    """All materials that objects show, each once, in order: those of their slots, and those that node modifiers set."""
    return list(_first_users(objects))


def relit_materials(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Material]:
    """Those of them that this version relights."""
    return [material for material in materials_of(objects) if is_relit(material)]


def is_relit(material: bpy.types.Material) -> bool:
    """Whether this version relights a material, and may restore it."""
    return is_local(material) and any(our_nodes(material.node_tree)) and not is_relit_by_newer(material)


def check_relit_materials(objects: Iterable[bpy.types.Object]) -> None:
    """Raises MeshError or VersionError for the first material that is relit, and cannot be restored."""
    for material, ob in _first_users(objects).items():
        if any(our_nodes(material.node_tree)):
            check_local(material, f"Material '{material.name}' of '{ob.name}'", "remove the shading", MeshError)
            check_version(material)


def _first_users(objects: Iterable[bpy.types.Object]) -> dict[bpy.types.Material, bpy.types.Object]:
    """Each material of the objects once, and the first of them that has it."""
    found: dict[bpy.types.Material, bpy.types.Object] = {}
    for ob in objects:
        for material in [slot.material for slot in ob.material_slots] + _set_by_nodes(ob):
            if material:
                found.setdefault(material, ob)
    return found


def _set_by_nodes(ob: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials that node modifiers bring: no slot of the object holds them."""
    if not any(modifier.type == "NODES" for modifier in ob.modifiers):
        return []
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [material.original for material in getattr(evaluated.data, "materials", ()) if material]


def add_shading(objects: Iterable[bpy.types.Object], anew: bool = True) -> list[Notice]:
    """Relight every material of the objects in EEVEE; objects or slots without a material get one.

    Args:
        objects: whose materials are relit.
        anew: also those that are relit.

    Returns:
        A notice on each material that is not relit, or not as it looks.
    """
    notices = []
    for material, two_sided in to_relight(objects, anew):
        notices += relight(material, two_sided)
    follow_receivers()
    return notices


def to_relight(objects: Iterable[bpy.types.Object], anew: bool) -> list[tuple[bpy.types.Material, bool]]:
    """The materials that `add_shading` relights, for `relight`, after it has filled empty slots.

    Returns:
        Them, each with whether meshes that show it have backs with transport of their own.
    """
    objects = list(objects)
    for ob in objects:
        if is_local(ob.data) and is_local(ob):
            _fill_empty_slots(ob)
    two_sided = _two_sided()
    return [(material, material in two_sided) for material in materials_of(objects) if anew or not is_relit(material)]


def relight(material: bpy.types.Material, two_sided: bool) -> list[Notice]:
    """Relight a material in EEVEE, again if it is; returns a notice if it is not, or not as it looks."""
    if not is_local(material):
        return [Notice(_FOREIGN, material.name)]
    if is_relit_by_newer(material):
        return [Notice(_NEWER, material.name)]
    remove_from_material(material)
    return _add_to_material(material, two_sided)


def _two_sided() -> set[bpy.types.Material]:
    """The materials of all objects whose backs have transport of their own."""
    return set(materials_of(ob for ob in bpy.data.objects if ob.type == "MESH" and has_backs(transport_mesh(ob))))


def remove_shading(objects: Iterable[bpy.types.Object]) -> int:
    """Restore the objects' materials, save those that other baked objects still show; how many of them were ours."""
    objects = list(objects)
    rest = [ob for ob in bpy.data.objects if ob.type == "MESH" and ob not in objects and is_baked(transport_mesh(ob))]
    still_used = set(materials_of(rest))
    return restore([material for material in materials_of(objects) if material not in still_used], objects)


def restore(materials: Iterable[bpy.types.Material], objects: Iterable[bpy.types.Object]) -> int:
    """Take our nodes out of materials, and from objects the materials that we made; how many of the former were ours."""
    removed = sum(map(remove_from_material, materials))
    for ob in objects:
        _empty_made_slots(ob)
    follow_receivers()
    if removed:
        remove_unused_group()
    return removed


def our_nodes(tree: bpy.types.NodeTree | None) -> Iterator[bpy.types.Node]:
    """The nodes we added to a material's tree."""
    for node in tree.nodes if tree else ():
        is_group = node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree)
        if is_group or OURS in node or PART in node:
            yield node


@contextmanager
def own_surfaces_active() -> Iterator[None]:
    """Inside, the outputs that were active before ours are active again in all relit materials: for those who look there."""
    before: list[tuple[bpy.types.Node, bool]] = []
    for material in filter(is_local, bpy.data.materials):
        ours = next((node for node in our_nodes(material.node_tree) if OURS in node), None)
        if ours is None:
            continue
        names = ours[OURS].split("\n")
        outputs = [node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"]
        before += [(node, node.is_active_output) for node in outputs]
        for node in outputs:
            node.is_active_output = node.name in names or VIEWPORT in node
    try:
        yield
    finally:
        for node, active in before:
            node.is_active_output = active


def remove_from_material(material: bpy.types.Material) -> bool:
    """Take our nodes out of a material and restore which output was active; True if there were any."""
    tree = material.node_tree
    ours = list(our_nodes(tree))
    were_active = {name for node in ours for name in node.get(OURS, "").split("\n")}
    if tree:
        remove_parts(tree)
    for node in list(our_nodes(tree)):
        tree.nodes.remove(node)
    if ours:
        for output in _outputs(tree):
            output.is_active_output = output.name in were_active
    if material.get(HAD_NO_NODES):
        turn_nodes(material, False)
        del material[HAD_NO_NODES]
    return bool(ours)


def follow_surface(material: bpy.types.Material, anew: bool = False) -> None:
    """Relight what the user's own surface now is, if that has changed.

    Textures and nodes are linked and need no following; a plain number cannot be linked, and a driver from a material
    to itself would be a dependency cycle.

    Args:
        material: that may be relit.
        anew: also if it looks the same from here: a group of it was edited.
    """
    groups = (
        node for node in our_nodes(material.node_tree) if node.bl_idname == "ShaderNodeGroup" and PART not in node
    )
    group = next((node for node in groups if not is_newer(node.node_tree)), None)
    if group:
        _follow_viewport_colour(material)
        _relight(material, group, anew)


def follow_group(tree: bpy.types.NodeTree) -> None:
    """A node group was edited: materials that show what lies inside of it, through a copy, get another."""
    copies = {copy for copy in bpy.data.node_groups if copy.get(PART) == tree.name}
    for material in bpy.data.materials if copies else ():
        if any(getattr(node, "node_tree", None) in copies for node in our_nodes(material.node_tree)):
            follow_surface(material, anew=True)


def _relight(material: bpy.types.Material, group: bpy.types.Node, anew: bool = False) -> None:
    """Have the group relight what the user's own surface now is."""
    tree, reading = material.node_tree, read_material(material, "EEVEE")
    whole = reading.output is not None and not reading.why_not
    wanted = structure(reading.output) if whole else _MATTE
    if is_local(material) and (group.get(_SURFACE) != wanted or anew):
        group[_SURFACE] = wanted
        remove_parts(tree, but=VIEWPORT)
        surface = _relit_where_baked(reading.output, group) if whole else group.outputs["Surface"]
        tree.links.new(surface, _our_output(tree).inputs["Surface"])
        _lay_out(tree, group)
    if not whole and isinstance(reading.colour, Constant):
        write(group.inputs["Base Color"], "default_value", (*reading.colour.rgb, 1.0))
    follow_numbers(tree)


def _relit_where_baked(output: bpy.types.Node, group: bpy.types.Node) -> bpy.types.NodeSocket:
    """The user's surface, relit where there is transport."""
    tree = output.id_data
    mix = add_part(tree, "ShaderNodeMixShader")
    users, relit = feeding_socket(output.inputs["Surface"]), build_surface(output, sockets_of(group))
    for entry, source in zip(mix.inputs, (group.outputs["Baked"], users, relit), strict=True):
        if source:
            tree.links.new(source, entry)
    return mix.outputs[0]


def _lay_out(tree: bpy.types.NodeTree, group: bpy.types.Node) -> None:
    """Parts in a staircase below the group, folded."""
    for row, node in enumerate(node for node in tree.nodes if PART in node and VIEWPORT not in node):
        node.location = (group.location.x + 30.0 * row, group.location.y - 220.0 - 40.0 * row)


def _our_output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    return next(node for node in our_nodes(tree) if OURS in node)


def _add_to_material(material: bpy.types.Material, two_sided: bool) -> list[Notice]:
    """Add our nodes; returns what there is to say about it.

    Args:
        material: that has none of our nodes.
        two_sided: whether meshes that show it have backs with transport of their own.
    """
    if not has_surface(material):
        return []
    reading = read_material(material, "EEVEE")
    said = [Notice(_GLOWS, material.name)] if reading.emits else []
    if reading.colour is None and not reading.why_not:
        return [*said, Notice(_LIGHTLESS, material.name)]
    count = len(attributes_read(reading.output)) if reading.output else 0
    if count > ROOM:
        return [Notice(_TOO_MANY_ATTRIBUTES, material.name, {"count": str(count), "most": str(ROOM)})]
    if two_sided and count > ROOM_WITH_BACKS:
        two_sided = False
        said.append(Notice(_NO_BACKS, material.name, {"count": str(count), "most": str(ROOM_WITH_BACKS)}))
    if not nodes_are_on(material):
        material[HAD_NO_NODES] = True
        turn_nodes(material, True)
        _show_viewport_colour(material)
    tree = material.node_tree
    output = user_output(tree, "EEVEE")

    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.width = relight_group(with_backs=two_sided), 200.0
    group.name = group.label = "PRT Relight"
    active = [node.name for node in _outputs(tree) if node.is_active_output]
    ours = tree.nodes.new("ShaderNodeOutputMaterial")
    ours.target, ours.name, ours.label = "EEVEE", OUTPUT, "PRT (EEVEE)"
    ours[OURS] = "\n".join(active)
    if material.get(HAD_NO_NODES):
        matte = next(node for node in tree.nodes if VIEWPORT in node).inputs["Surface"].links[0].from_socket
        tree.links.new(matte, group.inputs["Unbaked"])
    elif output:
        _share_links(tree, output, ours, group)
    for node in (group, ours):
        node.select = False
    ours.is_active_output = True
    _relight(material, group)
    return said + ([Notice(_GREY, material.name, {"why": reading.why_not})] if reading.why_not else [])


def _show_viewport_colour(material: bpy.types.Material) -> None:
    """What Cycles shows of a material without nodes, as nodes: a matte surface of its viewport colour."""
    tree = material.node_tree
    shader = add_part(tree, "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = material.diffuse_color
    output = add_part(tree, "ShaderNodeOutputMaterial")
    output.target, output.is_active_output = "CYCLES", True
    output[VIEWPORT] = True
    tree.links.new(shader.outputs[0], output.inputs["Surface"])


def _follow_viewport_colour(material: bpy.types.Material) -> None:
    for node in material.node_tree.nodes if material.get(HAD_NO_NODES) else ():
        if VIEWPORT in node and node.inputs["Surface"].is_linked:
            entry = node.inputs["Surface"].links[0].from_node.inputs["Color"]
            if tuple(entry.default_value) != tuple(material.diffuse_color):
                entry.default_value = material.diffuse_color


def _outputs(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial" and PART not in node]


def _share_links(tree: bpy.types.NodeTree, output: bpy.types.Node, ours: bpy.types.Node, group: bpy.types.Node) -> None:
    """Feed the user's surface to unbaked meshes, and the user's displacement and volume to our output."""
    group.location = (output.location.x, output.location.y - 260.0)
    ours.location = (output.location.x + 240.0, output.location.y - 260.0)
    for entry in output.inputs:
        source = feeding_socket(entry)
        if source:
            tree.links.new(source, group.inputs["Unbaked"] if entry.name == "Surface" else ours.inputs[entry.name])


def _fill_empty_slots(ob: bpy.types.Object) -> None:
    if not ob.material_slots and not _set_by_nodes(ob):
        ob.data.materials.append(_made_material())
        ob.data[_SLOT_ADDED] = True
    for slot in ob.material_slots:
        if slot.material is None:
            slot.material = _made_material()


def _made_material() -> bpy.types.Material:
    """The plain material for objects that have none; grey like Blender's own default."""
    for material in bpy.data.materials:
        if material.get(MADE) and material.library is None:
            return material
    material = bpy.data.materials.new("PRT Default")
    turn_nodes(material, True)
    material[MADE] = True
    return material


def _remove_slot(ob: bpy.types.Object, index: int) -> None:
    """Taking the material out of the mesh alone would leave an empty slot on the object."""
    if len(ob.material_slots) == 1:
        ob.data.materials.clear()
        return
    active, ob.active_material_index = ob.active_material_index, index
    with bpy.context.temp_override(object=ob):
        bpy.ops.object.material_slot_remove()
    ob.active_material_index = min(active, len(ob.material_slots) - 1)


def _empty_made_slots(ob: bpy.types.Object) -> None:
    for index in reversed(range(len(ob.material_slots))):
        material = ob.material_slots[index].material
        if material is None or not material.get(MADE) or any(our_nodes(material.node_tree)):
            continue
        if ob.data.get(_SLOT_ADDED):
            _remove_slot(ob, index)
            del ob.data[_SLOT_ADDED]
        else:
            ob.material_slots[index].material = None
        if not material.users:
            bpy.data.materials.remove(material)
