# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes meshes as (vertices, triangles), counter-clockwise seen from outside or from above."""

import numpy as np
import numpy.typing as npt

Mesh = tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]


def icosphere(subdivisions):
    """Unit sphere of 10 * 4**n + 2 vertices."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    corners = []
    for a in (-1.0, 1.0):
        for b in (-golden, golden):
            corners += [(0.0, a, b), (a, b, 0.0), (b, 0.0, a)]
    vertices = np.array(corners) / np.hypot(1.0, golden)
    edge = 2.0 / np.hypot(1.0, golden)
    near = np.linalg.norm(vertices[:, None] - vertices, axis=-1) < 1.01 * edge
    triangles = np.array(
        [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[k, i]]
    )
    inward = np.linalg.det(vertices[triangles]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    for _ in range(subdivisions):
        vertices, triangles = _subdivided(vertices, triangles)
    return vertices, triangles.astype(np.int32)


def _subdivided(vertices, triangles):
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middles = vertices[unique].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (inverse.reshape(-1, 3) + len(vertices)).T
    a, b, c = triangles.T
    quarters = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(corners, axis=1) for corners in quarters])


def bumpy_sphere(subdivisions):
    """A sphere with deep dents, which shadow a third of its own sky."""
    vertices, triangles = icosphere(subdivisions)
    x, y, z = vertices.T
    height = 1.0 + 0.45 * np.sin(8.0 * x + 1.0) * np.sin(7.0 * y) + 0.25 * np.sin(9.0 * z)
    return vertices * height[:, None], triangles


def torus(around=32, across=16, tube=0.45):
    """Ring of radius 1 about Z."""
    u, v = np.meshgrid(
        2.0 * np.pi * np.arange(around) / around, 2.0 * np.pi * np.arange(across) / across, indexing="ij"
    )
    ring = 1.0 + tube * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    here, next_u = i * across + j, (i + 1) % around * across + j
    next_v, both = i * across + (j + 1) % across, (i + 1) % around * across + (j + 1) % across
    return vertices, _quads(here, next_u, both, next_v)


def grid(cells, size=2.0):
    """Square in the plane z = 0, centred, facing +Z."""
    line = np.linspace(-size / 2.0, size / 2.0, cells + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    here = i * (cells + 1) + j
    return vertices, _quads(here, here + cells + 1, here + cells + 2, here + 1)


def box():
    """Cube from -1 to 1."""
    vertices = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    a, b, c, d = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]).T
    return vertices, _quads(a, b, c, d)


def disc(radius, height, sides=360):
    """Fan about the Z axis at that height, facing +Z."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(sides, height)], axis=-1)
    index = np.arange(sides)
    fan = np.stack([np.full(sides, sides), index, (index + 1) % sides], axis=-1)
    return np.concatenate([rim, [[0.0, 0.0, height]]]), fan.astype(np.int32)


def joined(*meshes) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    triangles = [triangles + start for (_, triangles), start in zip(meshes, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(triangles).astype(np.int32)


def vertex_normals(vertices, triangles):
    """Unit normals, weighed by area."""
    a, b, c = vertices[triangles.T]
    normals = np.zeros_like(vertices)
    for corner in triangles.T:
        np.add.at(normals, corner, np.cross(b - a, c - a))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _quads(a, b, c, d):
    corners = [np.ravel(corner) for corner in (a, b, c, d)]
    first, second = np.stack(corners[:3], axis=1), np.stack([corners[0], *corners[2:]], axis=1)
    return np.concatenate([first, second]).astype(np.int32)
