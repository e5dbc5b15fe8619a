# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a web page in one file: the viewer, and all that it shows."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Mapping
from typing import Any

TITLE, STILL, DATA = "[[TITLE]]", "[[STILL]]", "[[DATA]]"
"""Places in the viewer's file."""


def assembled(viewer: str, description: Mapping[str, Any], files: Mapping[str, bytes], still: bytes | None) -> str:
    """The page.

    Args:
        viewer: the viewer's file.
        description: plain data, as `web/packages/viewer/src/page.ts` has it; `title` among it.
        files: by the names that the description has for them.
        still: a JPEG of the scene, for browsers that cannot draw it.
    """
    text = json.dumps(description, separators=(",", ":")).replace("<", "\\u003c")
    data = [f'<script type="application/json" id="prt-scene">{text}</script>']
    data += [f'<script type="text/plain" id="{name}">{_packed(content)}</script>' for name, content in files.items()]
    picture = base64.b64encode(still).decode() if still else ""
    shown = f'<img alt="A still picture of the scene" src="data:image/jpeg;base64,{picture}">' if picture else ""
    title = html.escape(str(description["title"]))
    head, rest = viewer.replace(TITLE, title).split(STILL)
    middle, end = rest.split(DATA)
    return "".join([head, shown, middle, "\n".join(data), end])


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()
