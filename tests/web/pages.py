# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the pages that are exported, with the standard library and NumPy alone."""

import base64
import gzip
import json
import re
import struct

import numpy as np

PART = re.compile(r'<script type="([a-z/]+)" id="([\w-]+)">(.*?)</script>', re.DOTALL)


class ReadPage:
    """A page: its text, its description, and its files by their names."""

    def __init__(self, path):
        self.text = path.read_text(encoding="utf-8")
        parts = {name: (kind, text) for kind, name, text in PART.findall(self.text)}
        self.description = json.loads(parts.pop("prt-scene")[1])
        self.files = {name: gzip.decompress(base64.b64decode(text)) for name, (_, text) in parts.items()}
        self.packed_sizes = {name: len(base64.b64decode(text)) for name, (_, text) in parts.items()}
        model = self.files["prt-model"]
        length = struct.unpack_from("<I", model, 12)[0]
        self.document = json.loads(model[20 : 20 + length])
        self._binary = model[28 + length :]

    def view(self, index):
        """The bytes of a buffer view."""
        view = self.document["bufferViews"][index]
        return self._binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def transport(self, primitive):
        """(N, 9, 3) as it was packed: number after number, from vertex to vertex."""
        parts = self.parts(primitive)
        return parts[..., :3] + parts[..., 3:].sum(axis=-1, keepdims=True)

    def parts(self, primitive):
        """(N, 9, 3) transport, or, where the direct part is told apart, (N, 9, 4) bounces and that."""
        packed = primitive["extras"]["prt_relight"]
        vertices = self.document["accessors"][primitive["attributes"]["POSITION"]]["count"]
        channels = 4 if packed["direct"] else 3
        planes = np.frombuffer(self.view(packed["view"]), dtype=np.uint8).reshape(2, 9 * channels, vertices).astype(int)
        codes = planes[0] + 256 * planes[1]
        steps = np.where(codes % 2, -(codes + 1) // 2, codes // 2)
        numbers = np.cumsum(steps, axis=1).T.reshape(vertices, 9, channels)
        for channel, tint in zip((0, 2), packed["tints"], strict=True):
            numbers[:, :, channel] += (numbers[:, :, 1] * tint + 128) // 256
        return numbers * packed["scale"]
