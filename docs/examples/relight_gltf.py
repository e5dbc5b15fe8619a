# SPDX-License-Identifier: GPL-3.0-or-later
"""Relight a baked mesh outside Blender: reads an exported .gltf or .glb with NumPy and the standard library alone.

    python relight_gltf.py baked.glb [shaded.npz]

In Blender, with the extension enabled, File > Export > glTF 2.0 writes all that is needed, by its own settings: transport as
attributes, the light of the scene's world in the extras of the scene, and the materials as they were before the bake. Where
the transport lies behind modifiers, turn on Data > Mesh > Apply Modifiers.

What is computed for each vertex is what the extension's shader shows, `base_color * strength * max(sum_i T_i L'_i, 0)`
in linear light, where L' is the light as it is turned. Names and conventions: docs/formats.md.
"""

from __future__ import annotations

import base64
import json
import struct
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# glTF is Y up and Blender Z up: (x, y, z) in Blender is (x, z, -y) in glTF. The transport is not converted on export.
TO_GLTF = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])

COMPONENTS = {5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

# Band 2 as a symmetric form, Y_2m(w) c_m summed = w^T Q w: the constants of the basis.
K_XY, K_ZZ, K_XX = 1.092548, 0.315392, 0.546274


@dataclass
class BakedMesh:
    """One primitive of a baked mesh.

    positions: (N, 3) in Blender's axes, world space.
    transport: (N, 9, 3) in the axes whose columns are `axes`.
    backs: the same of the backs of its faces; None where these show what the fronts show.
    axes: (3, 3) the scene's (unit matrix), or the object's own.
    base_color: (3,) linear.
    triangles: (T, 3).
    """

    positions: np.ndarray
    transport: np.ndarray
    backs: np.ndarray | None
    axes: np.ndarray
    base_color: np.ndarray
    triangles: np.ndarray


def without_negatives(shading):
    """Move colours (n, 3) with a negative channel towards the grey of their mean, until none is negative."""
    least, mean = shading.min(axis=1, keepdims=True), shading.mean(axis=1, keepdims=True)
    share = np.minimum(np.maximum(-least, 0.0) / np.maximum(mean - least, 1e-9), 1.0)
    return np.maximum(shading + share * (mean - shading), 0.0)


def relight(mesh: BakedMesh, light: dict, of_backs: bool = False) -> np.ndarray:
    """(N, 3) what the vertices show, linear RGB, of their fronts or of their backs; the light as `read_light` has it."""
    turn = np.array(light["turn"]).T  # its columns are written
    turned = turned_light(np.array(light["light"]), turn @ mesh.axes)
    transport = mesh.backs if of_backs and mesh.backs is not None else mesh.transport
    shading = np.einsum("nic,ic->nc", transport, turned)
    return mesh.base_color * light["strength"] * without_negatives(shading)


def turned_light(light: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """The light (9, 3) that is seen along w where it was seen along R w: L'(w) = L(R w)."""
    result = light.copy()
    result[[3, 1, 2]] = turn.T @ light[[3, 1, 2]]  # band 1 is a vector; its order is y, z, x
    for channel, (xy, yz, zz, zx, xx) in enumerate(light[4:].T):
        form = np.array(
            [
                [K_XX * xx - K_ZZ * zz, K_XX * xy, K_XX * zx],
                [K_XX * xy, -K_XX * xx - K_ZZ * zz, K_XX * yz],
                [K_XX * zx, K_XX * yz, 2.0 * K_ZZ * zz],
            ]
        )
        q = turn.T @ form @ turn
        result[4:, channel] = [
            q[0, 1] / K_XX,
            q[1, 2] / K_XX,
            q[2, 2] / (2.0 * K_ZZ),
            q[0, 2] / K_XX,
            (q[0, 0] - q[1, 1]) / (2.0 * K_XX),
        ]
    return result


def read_light(path: Path) -> dict | None:
    """The light of a file's scene: (9, 3) coefficients, the three columns of its turn, a strength; None if there is none."""
    document, _ = _open(path)
    found = document["scenes"][document.get("scene", 0)].get("extras", {}).get("prt_relight", {})
    return found if "light" in found else None


def read_baked(path: Path) -> list[BakedMesh]:
    """All primitives of a .gltf or .glb that carry transport."""
    document, chunk = _open(path)
    buffers = [_buffer(buffer, chunk, path.parent) for buffer in document.get("buffers", [])]
    meshes = []
    for index, matrix in _world_matrices(document):
        node = document["nodes"][index]
        if "mesh" not in node:
            continue
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            if "_PRT_0" in primitive["attributes"]:
                meshes.append(_baked(document, buffers, primitive, matrix))
    return meshes


def _baked(document: dict, buffers: list[bytes], primitive: dict, matrix: np.ndarray) -> BakedMesh:
    attributes = primitive["attributes"]
    layers = _layers(document, buffers, primitive, [f"_PRT_{i}" for i in range(9)], "scales")
    local = _accessor(document, buffers, attributes["POSITION"])
    positions = (local @ matrix[:3, :3].T + matrix[:3, 3]) @ TO_GLTF
    axes = np.eye(3)
    if layers[0][0, 3] < -1.5:  # alpha of _PRT_0: in the object's own axes, the normalised columns of its matrix
        own = TO_GLTF.T @ matrix[:3, :3] @ TO_GLTF
        axes = own / np.linalg.norm(own, axis=0)
    transport = np.stack([layer[:, :3] for layer in layers], axis=1)
    triangles = np.arange(len(positions))
    if "indices" in primitive:
        triangles = _accessor(document, buffers, primitive["indices"])[:, 0].astype(np.int64)
    backs = _backs(document, buffers, primitive)
    return BakedMesh(positions, transport, backs, axes, _base_color(document, primitive), triangles.reshape(-1, 3))


def _backs(document: dict, buffers: list[bytes], primitive: dict) -> np.ndarray | None:
    """(N, 9, 3): nine numbers in three layers, in the one colour that their alphas hold two channels of."""
    names = [f"_PRT_B{k}" for k in range(3)]
    if any(name not in primitive["attributes"] for name in names):
        return None
    layers = np.stack(_layers(document, buffers, primitive, names, "backs"), axis=1)
    numbers = layers[:, :, :3].reshape(-1, 9)
    numbers[:, 0] += 1.0  # the mark of meshes that have backs
    red, green = layers[:, 1, 3], layers[:, 2, 3]
    return numbers[:, :, None] * np.stack([red, green, 3.0 - red - green], axis=1)[:, None]


def _layers(document: dict, buffers: list[bytes], primitive: dict, names: list[str], key: str) -> list[np.ndarray]:
    """Each layer (N, 4). In 16 bits, the primitive's extras hold scales by a key: of a layer's colour, and of its alpha."""
    found = [_accessor(document, buffers, primitive["attributes"][name]) for name in names]
    scales = primitive.get("extras", {}).get("prt_relight", {}).get(key, [(1.0, 1.0)] * len(names))
    return [layer * (colour, colour, colour, alpha) for layer, (colour, alpha) in zip(found, scales, strict=True)]


def _base_color(document: dict, primitive: dict) -> np.ndarray:
    """The material's plain colour; a texture, if there is one, still has to be multiplied in."""
    if "material" not in primitive:
        return np.ones(3)
    surface = document["materials"][primitive["material"]].get("pbrMetallicRoughness", {})
    return np.array(surface.get("baseColorFactor", [1.0] * 4)[:3])


def _open(path: Path) -> tuple[dict, bytes]:
    """The JSON of a file, and the binary chunk if it is a .glb."""
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    chunks, start = [], 12
    while start < len(data):
        (length,) = struct.unpack_from("<I", data, start)
        chunks.append(data[start + 8 : start + 8 + length])
        start += 8 + length
    return json.loads(chunks[0]), chunks[1] if len(chunks) > 1 else b""


def _buffer(buffer: dict, chunk: bytes, folder: Path) -> bytes:
    uri = buffer.get("uri")
    if uri is None:
        return chunk
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    return (folder / uri).read_bytes()


def _accessor(document: dict, buffers: list[bytes], index: int) -> np.ndarray:
    """(N, width) float64 of an accessor."""
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
    stride = view.get("byteStride", kind.itemsize * width)
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    values = np.ndarray((accessor["count"], width), kind, buffers[view["buffer"]], start, (stride, kind.itemsize))
    if accessor.get("normalized"):
        return np.maximum(values / float(np.iinfo(kind).max), -1.0)
    return values.astype(np.float64)


def _world_matrices(document: dict) -> list[tuple[int, np.ndarray]]:
    """Every node of the scene and its (4, 4) matrix."""
    scene = document["scenes"][document.get("scene", 0)]
    pending = [(index, np.eye(4)) for index in scene.get("nodes", [])]
    found = []
    while pending:
        index, parent = pending.pop()
        node = document["nodes"][index]
        matrix = parent @ _local_matrix(node)
        found.append((index, matrix))
        pending += [(child, matrix) for child in node.get("children", [])]
    return found


def _local_matrix(node: dict) -> np.ndarray:
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T  # columns come first
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", (1.0, 1.0, 1.0)))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def main(gltf: str, output: str = "") -> None:
    """Shade all baked primitives of a file."""
    light, meshes = read_light(Path(gltf)), read_baked(Path(gltf))
    if not meshes or light is None:
        sys.exit(f"'{gltf}' holds no {'light' if meshes else 'baked mesh'}: export it with PRT Relight enabled.")
    shaded = [relight(mesh, light) for mesh in meshes]
    for mesh, colours in zip(meshes, shaded, strict=True):
        print(f"{len(colours)} vertices, {len(mesh.triangles)} triangles, mean colour {colours.mean(axis=0).round(4)}")
    if output:
        positions = np.concatenate([mesh.positions for mesh in meshes])
        np.savez(output, positions=positions, colours=np.concatenate(shaded))


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
