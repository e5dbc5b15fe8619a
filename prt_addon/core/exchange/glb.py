# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes binary glTF files apart into their document and its pieces of data, and puts them together again."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

_MAGIC = b"glTF"
_JSON, _BINARY = b"JSON", b"BIN\0"
_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """One file: its JSON document, and the bytes of each of its buffer views."""

    def __init__(self, data: bytes) -> None:
        length = struct.unpack_from("<I", data, 12)[0]
        self.document: dict[str, Any] = json.loads(data[20 : 20 + length])
        start = 20 + length + 8
        self.views: list[bytes] = []
        for view in self.document.get("bufferViews", ()):
            first = start + view.get("byteOffset", 0)
            self.views.append(data[first : first + view["byteLength"]])

    def add_view(self, data: bytes) -> int:
        """Add a piece of data; its index."""
        self.views.append(data)
        self.document.setdefault("bufferViews", []).append({"buffer": 0})
        return len(self.views) - 1

    def values(self, index: int) -> npt.NDArray[np.generic]:
        """(count, width) what an accessor holds, as it is stored.

        Raises:
            ValueError: for accessors that are sparse or interleaved, which Blender does not write.
        """
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(_COMPONENTS[accessor["componentType"]]), _WIDTHS[accessor["type"]]
        if "sparse" in accessor or view.get("byteStride", width * kind.itemsize) != width * kind.itemsize:
            raise ValueError("sparse and interleaved accessors are not read")
        data = self.views[accessor["bufferView"]]
        flat = np.frombuffer(data, kind, accessor["count"] * width, accessor.get("byteOffset", 0))
        return flat.reshape(accessor["count"], width)

    def written(self) -> bytes:
        """The file again, without accessors and pieces of data that nothing refers to any more."""
        self._drop_unused()
        pieces, offset = [], 0
        for view, data in zip(self.document.get("bufferViews", ()), self.views, strict=True):
            view.update(buffer=0, byteOffset=offset, byteLength=len(data))
            pieces.append(data + bytes(-len(data) % 4))
            offset += len(pieces[-1])
        self.document["buffers"] = [{"byteLength": offset}] if offset else []
        text = json.dumps(self.document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), _JSON) + text + struct.pack("<I4s", offset, _BINARY) + b"".join(pieces)
        return struct.pack("<4sII", _MAGIC, 2, 12 + len(chunks)) + chunks

    def _drop_unused(self) -> None:
        document = self.document
        primitives = [one for mesh in document.get("meshes", ()) for one in mesh["primitives"]]
        used = {index for one in primitives for index in one["attributes"].values()}
        used |= {one["indices"] for one in primitives if "indices" in one}
        places = {old: new for new, old in enumerate(sorted(used))}
        document["accessors"] = [document["accessors"][old] for old in sorted(used)]
        for one in primitives:
            one["attributes"] = {name: places[index] for name, index in one["attributes"].items()}
            if "indices" in one:
                one["indices"] = places[one["indices"]]
        holders = [
            (one, "bufferView") for one in (*document["accessors"], *document.get("images", ())) if "bufferView" in one
        ]
        packed = [one["extras"]["prt_relight"] for one in primitives if "prt_relight" in one.get("extras", {})]
        packed += [one["backs"] for one in packed if isinstance(one.get("backs"), dict)]
        holders += [(one, "view") for one in packed if "view" in one]
        kept = sorted({holder[key] for holder, key in holders})
        document["bufferViews"] = [document["bufferViews"][old] for old in kept]
        self.views = [self.views[old] for old in kept]
        for holder, key in holders:
            holder[key] = kept.index(holder[key])
