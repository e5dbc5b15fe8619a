# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps all that is known for as long as Blender runs and stands in no file, and clears it in one place."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import bpy

    from .core.notices import Counted
    from .glances import LightGlance
    from .scene.bake.before import Before
    from .scene.bake.freshness import Freshness
    from .scene.mesh.record import BakeRecord
    from .worker.engine import Engine
    from .worker.job import Job


@dataclass
class Session:
    """What runs, and what was looked up. Data-blocks are known by their session's identifiers.

    engine, job: the process that computes, and what it works on.
    timer: wakes the operator that watches a job.
    before: what a preview of that job has replaced in the file; None while none is shown.
    notices: what the last bake of each scene had to say.
    checked: by object, its record when it was last checked, and the causes for which it was stale then.
    stale: by scene and object, the bakes that the last check found stale.
    glances: what panels show of the light of each world.
    outdated: worlds that have changed since.
    sky_energies: of the skies that were looked at, by the digest of the light made from them.
    icons: the small picture of the light; `icon_shows` is the digest of the light in it.
    sky_icons: small pictures of the skies that Blender ships.
    shapes_changed: whether an object was moved or its mesh edited since a scene was read for a bake.
    scene: the one of the last edit.
    lamps: whether there were lamps when surfaces were last looked at; None if they were not.
    projecting: whether a world is being projected, so that what that changes is no edit.
    """

    engine: Engine | None = None
    job: Job[Any] | None = None
    timer: bpy.types.Timer | None = None
    before: Before | None = None
    notices: dict[int, list[Counted]] = field(default_factory=dict)
    checked: dict[int, tuple[BakeRecord, frozenset[Any]]] = field(default_factory=dict)
    stale: dict[int, dict[int, Freshness]] = field(default_factory=dict)
    glances: dict[int, LightGlance] = field(default_factory=dict)
    outdated: set[int] = field(default_factory=set)
    sky_energies: dict[bytes, float] = field(default_factory=dict)
    icons: bpy.utils.previews.ImagePreviewCollection | None = None
    icon_shows: bytes = b""
    sky_icons: bpy.utils.previews.ImagePreviewCollection | None = None
    shapes_changed: bool = False
    scene: int = 0
    lamps: bool | None = None
    projecting: bool = False

    def forget_file(self) -> None:
        """Another file is open: nothing that was looked up holds any more, nor can anything be brought back."""
        self.before = self.lamps = None
        self.shapes_changed, self.scene = False, 0
        for known in (self.notices, self.checked, self.stale, self.glances, self.outdated, self.sky_energies):
            known.clear()


session = Session()
