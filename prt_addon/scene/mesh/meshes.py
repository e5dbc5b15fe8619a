# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads evaluated meshes as arrays in world space: triangles that block light, and points that receive it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float64
from ...core.files import digest
from ...core.problem import ReceiverGroup
from ...core.transport.raycast import SKIP

Int32 = npt.NDArray[np.int32]

Domain = Literal["POINT", "CORNER"]

_SAME_NORMAL = 1e-3  # largest difference of a component between shading normals that count as one
_BENT = np.cos(
    np.radians(10.0)
)  # of the angle between a shading normal and its faces, above which light from below them counts


@dataclass(frozen=True)
class Surface:
    """World-space triangles of one object.

    vertices: (V, 3) float64.
    triangles: (T, 3) vertices, counter-clockwise from the front.
    corners: (T, 3) the mesh's face corners that these are.
    material: (T,) index of the material slot.
    one_sided: (T,) whether light passes through the back.
    """

    vertices: Float64
    triangles: Int32
    corners: Int32
    material: Int32
    one_sided: npt.NDArray[np.bool_]

    @cached_property
    def slots(self) -> list[int]:
        """The material slots that its triangles have."""
        return [int(index) for index in np.unique(self.material)]

    def with_sides(self, one_sided: Iterable[int]) -> Surface:
        """The same surface, with light passing through the backs of some material slots."""
        return replace(self, one_sided=np.isin(self.material, list(one_sided)))

    def without(self, slots: Iterable[int]) -> Surface:
        """The same surface without the triangles of some material slots."""
        kept = ~np.isin(self.material, list(slots))
        return Surface(
            self.vertices, self.triangles[kept], self.corners[kept], self.material[kept], self.one_sided[kept]
        )


@dataclass(frozen=True)
class ObjectReceivers:
    """The receivers of one object and where their transport is stored.

    group: those of the fronts of its faces.
    element_receiver: (elements of the domain,) index of the receiver that each vertex or face corner shows.
    backs: as many again, in the same places, that look the other way; None if backs are not seen.
    """

    group: ReceiverGroup
    domain: Domain
    element_receiver: npt.NDArray[np.int64]
    backs: ReceiverGroup | None = None

    def __len__(self) -> int:
        return sum(map(len, self.groups))

    @property
    def groups(self) -> list[ReceiverGroup]:
        """Fronts, then backs if there are any."""
        return [self.group] if self.backs is None else [self.group, self.backs]

    def with_backs(self) -> ObjectReceivers:
        """The same, and receivers of the backs."""
        horizons = None if self.group.horizons is None else -self.group.horizons
        return replace(self, backs=replace(self.group, normals=-self.group.normals, horizons=horizons))

    def at_corners(self, surface: Surface) -> npt.NDArray[np.int64]:
        """(T, 3) the receiver at each corner of the triangles of the object's own surface."""
        return self.element_receiver[surface.triangles if self.domain == "POINT" else surface.corners]


def vector_array(items: bpy.types.bpy_prop_collection, name: str) -> Float64:
    """(N, 3) float64 of a three-float property of a bpy collection."""
    flat = np.empty(len(items) * 3, dtype=np.float32)
    items.foreach_get(name, flat)
    return flat.reshape(-1, 3).astype(np.float64)


def index_array(items: bpy.types.bpy_prop_collection, name: str, width: int = 1) -> Int32:
    """(N,) or (N, width) int32 of an integer property of a bpy collection."""
    flat = np.empty(len(items) * width, dtype=np.int32)
    items.foreach_get(name, flat)
    return flat if width == 1 else flat.reshape(-1, width)


def corner_vertices(mesh: bpy.types.Mesh) -> Int32:
    """(corners,) the vertex of each face corner. From the layer it is stored in: 200 times as fast as from `loops`."""
    return (
        _stored(mesh, ".corner_vert", 1)
        if ".corner_vert" in mesh.attributes
        else index_array(mesh.loops, "vertex_index")
    )


def edge_vertices(mesh: bpy.types.Mesh) -> Int32:
    """(edges, 2) the vertices of each edge, likewise."""
    return (
        _stored(mesh, ".edge_verts", 2) if ".edge_verts" in mesh.attributes else index_array(mesh.edges, "vertices", 2)
    )


def face_starts(mesh: bpy.types.Mesh) -> Int32:
    """(faces,) the first corner of each: a face of n corners is n - 2 triangles, and these are quick to read."""
    mesh.calc_loop_triangles()
    triangles = np.bincount(index_array(mesh.loop_triangle_polygons, "value"), minlength=len(mesh.polygons))
    return (np.cumsum(triangles + 2) - (triangles + 2)).astype(np.int32)


def _stored(mesh: bpy.types.Mesh, layer: str, width: int) -> Int32:
    return index_array(mesh.attributes[layer].data, "value", width)


def layer_array(mesh: bpy.types.Mesh, layer: str, key: str, width: int) -> npt.NDArray[np.float32]:
    """(N, width) float32 of an attribute, in its own domain."""
    data = mesh.attributes[layer].data
    flat = np.empty(len(data) * width, dtype=np.float32)
    data.foreach_get(key, flat)
    return flat.reshape(-1, width)


def positions(mesh: bpy.types.Mesh) -> bytes:
    """Digest where the vertices lie."""
    return digest(layer_array(mesh, "position", "vector", 3))


def same_topology(one: bpy.types.Mesh, other: bpy.types.Mesh) -> bool:
    """Whether two meshes have the same vertices in the same faces, so that attributes fit both."""
    if (len(one.vertices), len(one.loops), len(one.polygons)) != (
        len(other.vertices),
        len(other.loops),
        len(other.polygons),
    ):
        return False
    same_corners = np.array_equal(corner_vertices(one), corner_vertices(other))
    return same_corners and (_is_triangles(one) or np.array_equal(face_starts(one), face_starts(other)))


def read_surface(mesh: bpy.types.Mesh, matrix: Float64) -> Surface:
    """Triangles of an evaluated mesh under a (4, 4) matrix; a mirroring matrix keeps fronts in front.

    All block light from both sides: see `Surface.with_sides`.
    """
    order = slice(None, None, -1 if np.linalg.det(matrix[:3, :3]) < 0.0 else 1)
    corners = _triangle_corners(mesh)[:, order]
    return Surface(
        vertices=_transformed(_positions(mesh), matrix),
        triangles=corner_vertices(mesh)[corners],
        corners=corners,
        material=(material := _triangle_materials(mesh)),
        one_sided=np.zeros(len(material), dtype=np.bool_),
    )


def _is_triangles(mesh: bpy.types.Mesh) -> bool:
    """Whether every face is one: none has fewer corners."""
    return len(mesh.loops) == 3 * len(mesh.polygons)


def _positions(mesh: bpy.types.Mesh) -> Float64:
    layer = mesh.attributes.get("position")
    return vector_array(layer.data, "vector") if layer else np.zeros((0, 3))  # a mesh without vertices may have none


def _triangle_corners(mesh: bpy.types.Mesh) -> Int32:
    """(T, 3) the face corners of each triangle."""
    if _is_triangles(mesh):
        return np.arange(len(mesh.loops), dtype=np.int32).reshape(-1, 3)
    mesh.calc_loop_triangles()
    return index_array(mesh.loop_triangles, "loops", 3)


def _triangle_materials(mesh: bpy.types.Mesh) -> Int32:
    """(T,) index of the material slot."""
    mesh.calc_loop_triangles()
    face = index_array(mesh.loop_triangle_polygons, "value")
    if "material_index" not in mesh.attributes:
        return np.zeros_like(face)
    return _stored(mesh, "material_index", 1)[face]


def read_receivers(name: str, mesh: bpy.types.Mesh, matrix: Float64) -> ObjectReceivers:
    """Receivers of an evaluated mesh: one per vertex, or one per distinct (vertex, shading normal) pair.

    Where the corners of some vertex have different shading normals (flat faces, sharp edges, custom normals), one
    value per vertex would smear light around the edge: the transport then lives on face corners.
    """
    points = _transformed(_positions(mesh), matrix)
    radius = float(np.linalg.norm(np.ptp(points, axis=0))) / 2.0 if len(points) else 0.0
    to_world = np.linalg.pinv(matrix[:3, :3])  # normals turn by the inverse transpose; flat scales have no inverse
    vertex_normal = _unit(vector_array(mesh.vertex_normals, "vector") @ to_world)
    differ = mesh.normals_domain != "POINT"  # or else the corners show those of their vertices
    if differ:
        corner_vertex = corner_vertices(mesh)
        corner_normal = _unit(vector_array(mesh.corner_normals, "vector") @ to_world)
        vertex_normal[corner_vertex] = corner_normal  # loose vertices have no corner
        differ = np.abs(corner_normal - vertex_normal[corner_vertex]).max(initial=0.0) >= _SAME_NORMAL
    if not differ:
        inside = _with_pulled_boundary(mesh, matrix, points, vertex_normal, radius)
        horizons = _horizons(mesh, matrix, points, vertex_normal, corner_vertices(mesh))
        group = ReceiverGroup(name, inside, vertex_normal, radius, edges=edge_vertices(mesh), horizons=horizons)
        return ObjectReceivers(group, "POINT", np.arange(len(points)))

    corner, element_receiver = _distinct(corner_vertex, corner_normal)
    normals = corner_normal[corner]
    everywhere = np.arange(len(corner_vertex))
    inside = _pulled_into_faces(
        mesh, matrix, everywhere, points[corner_vertex], corner_normal, element_receiver, len(corner), radius
    )
    edges = element_receiver[_face_edges(mesh)].astype(np.int32)
    horizons = _horizons(mesh, matrix, points, normals, element_receiver)
    group = ReceiverGroup(name, inside, normals, radius, edges=edges, horizons=horizons)
    return ObjectReceivers(group, "CORNER", element_receiver)


def _horizons(
    mesh: bpy.types.Mesh,
    matrix: Float64,
    points: Float64,
    normals: Float64,
    corner_receiver: npt.NDArray[np.integer[Any]],
) -> Float64 | None:
    """The faces' own normals at receivers whose shading normals are bent away from them, zero elsewhere; None if nowhere.

    Args:
        mesh: that was evaluated.
        matrix: (4, 4) that took its vertices to
        points: (V, 3).
        normals: (N, 3) of the receivers.
        corner_receiver: (corners,) which receiver each face corner shows.
    """
    if not mesh.has_custom_normals:
        return None
    triangles = _triangle_corners(mesh)  # Blender's own normals of faces are bent, too
    a, b, c = np.moveaxis(points[corner_vertices(mesh)[triangles]], 1, 0)
    area = np.cross(b - a, c - a) * np.sign(np.linalg.det(matrix[:3, :3]))
    by_faces = _unit(_mean_of_pairs(np.repeat(area, 3, axis=0), corner_receiver[triangles].ravel(), len(normals)))
    bent = np.einsum("ij,ij->i", normals, by_faces) < _BENT
    return np.where(bent[:, None], by_faces, 0.0) if bent.any() else None


def _mean_of_pairs(values: Float64, pair: npt.NDArray[np.integer[Any]], count: int) -> Float64:
    """(count, 3) means of what belongs to each pair."""
    share = np.maximum(np.bincount(pair, minlength=count), 1)[:, None]  # loose vertices have no corner
    return np.stack([np.bincount(pair, values[:, k], count) for k in range(3)], axis=-1) / share


def _face_sizes(mesh: bpy.types.Mesh) -> Int32:
    """(faces,) corners of each."""
    return index_array(mesh.polygons, "loop_total")


def _with_pulled_boundary(
    mesh: bpy.types.Mesh, matrix: Float64, points: Float64, normals: Float64, radius: float
) -> Float64:
    """Points of vertices, those on open boundaries moved a hair into their faces.

    Where sheets touch without sharing vertices, as the walls and the floor of a room do, each one's boundary lies in the
    other, as if on a hard edge: see `_pulled_into_faces`.
    """
    boundary = _boundary_vertices(mesh)
    corner_vertex = corner_vertices(mesh)
    corners = np.flatnonzero(boundary[corner_vertex])
    if not len(corners):
        return points
    vertices, pair = np.unique(corner_vertex[corners], return_inverse=True)
    at = corner_vertex[corners]
    moved = points.copy()
    moved[vertices] = _pulled_into_faces(mesh, matrix, corners, points[at], normals[at], pair, len(vertices), radius)
    return moved


def _boundary_vertices(mesh: bpy.types.Mesh) -> npt.NDArray[np.bool_]:
    """(V,) whether each vertex ends an edge of a single face."""
    found = np.zeros(len(mesh.vertices), dtype=np.bool_)
    found[edge_vertices(mesh)[_faces_at_edges(mesh) == 1]] = True
    return found


def is_open(mesh: bpy.types.Mesh) -> bool:
    """Whether some edge has a single face, so that backs of faces may be seen."""
    return bool((_faces_at_edges(mesh) == 1).any())


def _faces_at_edges(mesh: bpy.types.Mesh) -> npt.NDArray[np.int64]:
    """(edges,) how many faces each has."""
    stored = ".corner_edge" in mesh.attributes
    edge = _stored(mesh, ".corner_edge", 1) if stored else index_array(mesh.loops, "edge_index")
    return np.bincount(edge, minlength=len(mesh.edges))


def own_axes(matrix: npt.ArrayLike) -> Float64:
    """(3, 3) columns: the axes of an object in the world, from its (4, 4) matrix as the shader finds them: normalised.

    Mirrored where the object is; NaN where it is scaled to zero.
    """
    columns = np.array(matrix, dtype=np.float64)[:3, :3]
    with np.errstate(divide="ignore", invalid="ignore"):
        return columns / np.linalg.norm(columns, axis=0)


def _transformed(points: Float64, matrix: Float64) -> Float64:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _unit(vectors: Float64) -> Float64:
    """Unit vectors; what has no length (a vertex of zero-area faces) points up."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    usable = np.isfinite(length) & (length > 0.0)
    return np.where(usable, vectors / np.where(usable, length, 1.0), (0.0, 0.0, 1.0))


def _distinct(vertex: Int32, normal: Float64) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """For corners: one corner of each distinct (vertex, normal) pair, and the pair of each corner."""
    steps = np.rint(normal * (1 << 12)).astype(np.int64) + (1 << 12)
    packed = (steps[:, 0] << 28) | (steps[:, 1] << 14) | steps[:, 2]
    different, normal_id = np.unique(packed, return_inverse=True)
    _, corner, pair = np.unique(
        vertex.astype(np.int64) * len(different) + normal_id, return_index=True, return_inverse=True
    )
    return corner, pair


def _face_edges(mesh: bpy.types.Mesh) -> npt.NDArray[np.int64]:
    """(corners, 2) each face corner and the next one around its face."""
    after = np.arange(1, len(mesh.loops) + 1)
    first = face_starts(mesh)
    after[np.append(first[1:], len(mesh.loops)) - 1] = first
    return np.stack([np.arange(len(after)), after], axis=1)


def _pulled_into_faces(
    mesh: bpy.types.Mesh,
    matrix: Float64,
    corners: npt.NDArray[np.int64],
    corner_point: Float64,
    corner_normal: Float64,
    pair: npt.NDArray[np.int64],
    count: int,
    radius: float,
) -> Float64:
    """Points of (vertex, normal) pairs, moved a hair from the hard edge into their own faces.

    On a hard edge the neighbouring face passes through the vertex itself, and a ray that should hit it may start
    behind it: the corners of a room would leak light. The move is along the tangent plane; where the faces rise
    above that plane (a concave smooth fan) the point stays, as it would end up below them.

    Args:
        mesh: that was evaluated.
        matrix: (4, 4) that took its vertices to the points.
        corners: (n,) some corners of the mesh, for each of which follow the point, the normal and the pair.
        corner_point: (n, 3) where each lies.
        corner_normal: (n, 3) its shading normal.
        pair: (n,) the (vertex, normal) pair that it belongs to.
        count: number of the pairs.
        radius: of the mesh; a hair is a share of it.
    """
    centre = _transformed(vector_array(mesh.polygons, "center"), matrix)
    sizes = _face_sizes(mesh)
    corner_face = np.repeat(np.arange(len(sizes)), sizes)[corners]  # faces are stored in the order of their corners
    normal = _unit(_mean_of_pairs(corner_normal, pair, count))
    point = _mean_of_pairs(corner_point, pair, count)
    inward = _mean_of_pairs(centre[corner_face], pair, count) - point
    height = np.einsum("ij,ij->i", inward, normal)
    inward -= height[:, None] * normal
    reach = np.linalg.norm(inward, axis=1)
    step = np.minimum(np.maximum(1e-3 * reach, 3.0 * SKIP * radius), 0.25 * reach)
    step[height > 1e-4 * reach] = 0.0
    return point + inward * (step / np.where(reach > 0.0, reach, 1.0))[:, None]
