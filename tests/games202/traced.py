# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces the exported mesh in NumPy: the light of each pixel, as the page should draw it."""

import numpy as np

from tests.games202.probes import SIZE, STEP

FIELD_OF_VIEW = np.radians(40.0)
SIGNS = np.array([1, -1, 1, -1, 1, -1, 1, -1, 1])  # Condon-Shortley


def triangles_of(path):
    """(T, 3, 3) places of an .obj's corners."""
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([words[1:4] for words in lines if words[:1] == ["v"]], dtype=float)
    faces = [[int(word.split("/")[0]) - 1 for word in words[1:]] for words in lines if words[:1] == ["f"]]
    return vertices[np.array(faces)]


def rays_of_pixels(axes):
    """(rows, columns, 3) unit directions of the compared pixels, row 0 at the bottom."""
    line = ((2.0 * np.arange(0, SIZE, STEP) + 1.0) / SIZE - 1.0) * np.tan(FIELD_OF_VIEW / 2.0)
    x, y = np.meshgrid(line, line)
    rays = x[..., None] * axes[0] + y[..., None] * axes[1] - axes[2]
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def first_hits(triangles, origins, rays):
    """(N,) distances, inf where nothing is met, triangles, and (N, 3) barycentrics (Moeller & Trumbore 1997)."""
    corner, first, second = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(rays[:, None], second)
    volume = (across * first).sum(axis=-1)
    volume = np.where(np.abs(volume) > 1e-12, volume, 1e-12)
    offset = origins[:, None] - corner
    u = (across * offset).sum(axis=-1) / volume
    along = np.cross(offset, first)
    v = (rays[:, None] * along).sum(axis=-1) / volume
    distance = (second * along).sum(axis=-1) / volume
    distance = np.where((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 1e-4), distance, np.inf)
    ray, hit = np.arange(len(rays)), distance.argmin(axis=1)
    u, v = u[ray, hit], v[ray, hit]
    return distance[ray, hit], hit, np.stack([1.0 - u - v, u, v], axis=-1)


def shown(colours, hit, weights):
    """(N, 3) between the corners' colours, and nothing below 0."""
    return np.maximum((colours[hit] * weights[..., None]).sum(axis=1), 0.0)
