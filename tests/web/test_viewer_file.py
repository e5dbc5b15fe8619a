# SPDX-License-Identifier: GPL-3.0-or-later
"""The built viewer that lies in the extension: not older than its sources, small, and in need of nothing."""

import gzip
import hashlib
import re

import pytest

from tests.web.node import WEB, npm

BUILT = WEB.parent / "prt_addon" / "scene" / "export" / "viewer.html"
SOURCES = ("packages/core/src/", "packages/viewer/src/")


def digest():
    """Of all sources, by their names, as build.mjs reckons it."""
    whole = hashlib.sha256()
    for folder in SOURCES:
        for path in sorted((WEB / folder).iterdir()):
            whole.update(f"{folder}{path.name}\n".encode() + path.read_bytes())
    return whole.hexdigest()


def test_it_is_built_from_these_sources():
    told = re.search(r"Digest of the sources: (\w+)", BUILT.read_text(encoding="utf-8"))
    assert told and told[1] == digest(), "prt_addon/scene/export/viewer.html is older than its sources: run make web"


def test_it_is_small_and_asks_no_network():
    text = BUILT.read_text(encoding="utf-8")
    assert len(gzip.compress(text.encode())) < 250_000
    assert not re.findall(r"https?://|fetch\(|XMLHttpRequest|\bimport\(|@import|url\(", text)


@pytest.mark.once
def test_building_it_again_gives_the_same_bytes():
    before = BUILT.read_bytes()
    done = npm("run", "build", "--workspace", "@prt-relight/viewer")
    after = BUILT.read_bytes()
    BUILT.write_bytes(before)
    assert done.returncode == 0, done.stderr
    assert after == before, "another version of the build's tools made the viewer: npm ci, then make web"
