# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary glTF files come apart and go together without a loss."""

import struct

import numpy as np
import pytest

from prt_addon.core.exchange.glb import Glb


def file_of(document, binary):
    """A file by hand."""
    import json

    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.fixture
def small():
    """Two accessors, of which a mesh uses the second; a picture of three bytes."""
    numbers = np.arange(6, dtype=np.float32)
    document = {
        "bufferViews": [
            {"buffer": 0, "byteLength": 4},
            {"buffer": 0, "byteOffset": 4, "byteLength": 24},
            {"buffer": 0, "byteOffset": 28, "byteLength": 3},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5121, "type": "SCALAR", "count": 4},
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": 2},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}}]}],
        "images": [{"bufferView": 2, "mimeType": "image/png"}],
    }
    return file_of(document, b"\1\2\3\4" + numbers.tobytes() + b"png"), numbers.reshape(2, 3)


def test_what_is_used_stays_and_the_rest_goes(small):
    data, numbers = small
    glb = Glb(data)
    np.testing.assert_array_equal(glb.values(0).ravel(), [1, 2, 3, 4])
    glb.document["meshes"][0]["primitives"][0]["extras"] = {"prt_relight": {"view": glb.add_view(b"packed")}}
    again = Glb(glb.written())
    [primitive] = again.document["meshes"][0]["primitives"]
    np.testing.assert_array_equal(again.values(primitive["attributes"]["POSITION"]), numbers)
    assert len(again.document["accessors"]) == 1
    assert again.views[again.document["images"][0]["bufferView"]] == b"png"
    assert again.views[primitive["extras"]["prt_relight"]["view"]] == b"packed"
    assert all(view["byteOffset"] % 4 == 0 for view in again.document["bufferViews"])
    assert struct.unpack_from("<I", glb.written(), 8)[0] == len(glb.written())


def test_interleaved_accessors_are_refused(small):
    glb = Glb(small[0])
    glb.document["bufferViews"][1]["byteStride"] = 16
    with pytest.raises(ValueError, match="interleaved"):
        glb.values(1)
