# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files of pieces are refused in one sentence: none is believed, waited for or let grow."""

import io
import json
import os
import threading
import zipfile

import numpy as np
import pytest

from prt_addon.core.errors import ShardError

from .test_shards import bake_shards, folder_of


def parts_of(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def header_of(parts):
    return json.loads(np.load(io.BytesIO(parts["header.npy"])).item())


def with_header(parts, **changes):
    return parts | {"header.npy": npy(np.array(json.dumps(header_of(parts) | changes)))}


def with_array(parts, name, change):
    array = np.load(io.BytesIO(parts[f"{name}.npy"])).copy()
    return parts | {f"{name}.npy": npy(change(array))}


def without(parts, name):
    return {key: value for key, value in parts.items() if key != name}


def put(array, index, value):
    array[index] = value
    return array


CONTENTS = {
    "start is text": lambda p: with_header(p, start="0"),
    "start is true": lambda p: with_header(p, start=True),
    "stop before start": lambda p: with_header(p, start=5, stop=2),
    "stop beyond all receivers": lambda p: with_header(p, stop=1 << 40),
    "shard of three numbers": lambda p: with_header(p, shard=[0, 1, 2]),
    "shard of text": lambda p: with_header(p, shard="01"),
    "shard -1": lambda p: with_header(p, shard=[-1, 2]),
    "header is a list": lambda p: p | {"header.npy": npy(np.array("[1, 2]"))},
    "header is a number": lambda p: p | {"header.npy": npy(np.array(7.0))},
    "header is 100,000 deep": lambda p: p | {"header.npy": npy(np.array("[" * 100_000))},
    "header is pickled": lambda p: p | {"header.npy": npy(np.array({"a": 1}, dtype=object))},
    "no header": lambda p: without(p, "header.npy"),
    "no direct": lambda p: without(p, "direct.npy"),
    "direct of one row": lambda p: with_array(p, "direct", lambda a: a[:1]),
    "direct of NaN": lambda p: with_array(p, "direct", lambda a: put(a, (0, 0), np.nan)),
    "direct of doubles": lambda p: with_array(p, "direct", lambda a: a.astype(np.float64)),
    "hits without starts": lambda p: without(p, "starts.npy"),
    "starts that fall": lambda p: with_array(p, "starts", lambda a: put(a, 1, 1 << 40)),
    "starts of integers of 32 bits": lambda p: with_array(p, "starts", lambda a: a.astype(np.int32)),
    "hits too few": lambda p: with_array(p, "packed", lambda a: a[:-1]),
    "no hits": lambda p: without(without(p, "starts.npy"), "packed.npy"),
    "another part": lambda p: p | {"more.npy": npy(np.zeros(3))},
    "declared 3.3 TiB": lambda p: p | {"direct.npy": npy(np.zeros((1, 9), np.float32)).replace(b"(1, 9)", b"(99999999999, 9)")},
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    """Two shards of an interreflected bake."""
    bake_shards(tmp_path, 2)
    return tmp_path


def largest(folder):
    """The file with the most hits."""
    return max(folder.iterdir(), key=lambda path: path.stat().st_size)


def stored(path, parts, compression=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)


@pytest.mark.parametrize("case", CONTENTS)
def test_wrong_contents_under_right_checksums(folder, case):
    path = largest(folder)
    stored(path, CONTENTS[case](parts_of(path)))
    with pytest.raises(ShardError, match="is damaged: delete it"):
        folder_of(folder).check_complete()


def test_corners_out_of_range_are_traced_again(folder):
    """What hits lie on is known once the scene is there."""
    path = largest(folder)
    stored(path, with_array(parts_of(path), "packed", lambda a: put(a, 0, (1 << 63) + 5)))
    pieces = folder_of(folder)

    def trace(_part):
        raise LookupError("its receivers have to be traced")

    with pytest.raises(LookupError):
        list(pieces.cover(slice(0, pieces.key.receivers), 1 << 20, trace, 3000))


def compressed(path, parts):
    stored(path, parts, zipfile.ZIP_DEFLATED)


def bomb(path, parts):
    """A gibibyte of zeros in a mebibyte."""
    stored(path, parts | {"direct.npy": npy(np.zeros((1, 9), np.float32)) + bytes(1 << 28)}, zipfile.ZIP_DEFLATED)


def encrypted(path, parts):
    stored(path, parts)
    content = bytearray(path.read_bytes())
    at = content.find(b"PK\x01\x02")
    while at >= 0:
        content[at + 8] |= 1
        at = content.find(b"PK\x01\x02", at + 4)
    path.write_bytes(content)


def unknown_compression(path, parts):
    stored(path, parts)
    content = bytearray(path.read_bytes())
    content[content.find(b"PK\x01\x02") + 10] = 77
    path.write_bytes(content)


def twice_the_same_part(path, parts):
    with pytest.warns(UserWarning, match="Duplicate name"), zipfile.ZipFile(path, "w") as archive:
        for name, content in [*parts.items(), *parts.items()]:
            archive.writestr(name, content)


def cut_off(path, parts):
    stored(path, parts)
    path.write_bytes(path.read_bytes()[:-40])


def empty(path, _parts):
    path.write_bytes(b"")


@pytest.mark.parametrize(
    "make", [compressed, bomb, encrypted, unknown_compression, twice_the_same_part, cut_off, empty]
)
def test_archives_that_we_do_not_write(folder, make):
    path = largest(folder)
    parts = parts_of(path)
    path.unlink()
    make(path, parts)
    with pytest.raises(ShardError, match="is damaged: delete it"):
        folder_of(folder).check_complete()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names")
def test_a_pipe_is_not_waited_for(folder):
    path = largest(folder)
    path.unlink()
    os.mkfifo(path)
    said = []

    def check():
        try:
            folder_of(folder).check_complete()
        except ShardError as error:
            said.append(str(error))

    looking = threading.Thread(target=check, daemon=True)
    looking.start()
    looking.join(5.0)
    assert not looking.is_alive() and "is damaged" in said[0]
