# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the nodes that the glTF exporter has gathered, and where they stand in the world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from mathutils import Matrix, Quaternion, Vector


def placed(nodes: Iterable[Any], parent: Matrix | None = None) -> Iterator[tuple[Any, Matrix]]:
    """All nodes below some, each with its matrix in the scene, in glTF's axes."""
    for node in nodes:
        matrix = (parent or Matrix()) @ _local(node)
        yield node, matrix
        yield from placed(node.children or (), matrix)


def _local(node: Any) -> Matrix:
    if node.matrix:
        return Matrix([node.matrix[row::4] for row in range(4)])  # columns come first
    x, y, z, w = node.rotation or (0.0, 0.0, 0.0, 1.0)
    place, scale = Vector(node.translation or (0.0,) * 3), Vector(node.scale or (1.0,) * 3)
    return Matrix.LocRotScale(place, Quaternion((w, x, y, z)), scale)
