# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes previews: few rays and one bounce, shown while the whole bake goes on, which they do not change by a bit.

Before the first there is light without shadows, which takes no rays. Each has four times the rays of the one before, which leaves
about a third of its noise. Receivers inside other geometry are not mended in them: that takes as long whatever the number of rays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..problem import BakeProblem, BakeSettings, Island
from ..workers import uncounted
from .bake import BakeResult, bake
from .run import Run

FIRST = 16
"""Rays per receiver of the first preview: 6 % of noise are left."""

_GROWTH = 4
_SHARE = 10  # of all rays, at most one in so many is cast for previews
_WORTH = 1 << 21  # rays, which take half a second: a bake of fewer is there as soon as its preview


@dataclass(frozen=True)
class Preview:
    """A bake of few rays that is shown before the whole one is done.

    Attributes:
        settings: those that it was baked with.
        samples: rays per receiver that the whole bake casts.
    """

    settings: BakeSettings
    samples: int
    result: BakeResult

    @property
    def text(self) -> str:
        """What is seen of the bake, in words."""
        return extent(self.settings, self.samples)


def extent(settings: BakeSettings, samples: int) -> str:
    """How much a preview of some settings shows of a bake of so many rays per receiver, in words."""
    return f"{settings.samples} of {samples} rays" if settings.casts_rays else "without shadows"


def preview_settings(settings: BakeSettings) -> Iterator[BakeSettings]:
    """The settings of each preview of a bake, in their order; none if together they took more than a tenth of its rays."""
    samples, left = FIRST, settings.samples // _SHARE
    while samples <= left:
        yield replace(settings, samples=samples, bounces=min(1, settings.bounces), tolerance=0.0)
        samples, left = samples * _GROWTH, left - samples


def is_worth(problem: BakeProblem) -> bool:
    """Whether a bake takes long enough for previews."""
    return problem.casts_rays and problem.work.rays >= _WORTH


def open_sky(problem: BakeProblem) -> Preview:
    """What there is of a bake at once: no shadow and no bounce. Takes milliseconds; errors as those of `bake`."""
    settings = replace(problem.settings, mode="UNSHADOWED")
    return Preview(settings, problem.settings.samples, bake(BakeProblem(problem.islands, settings)))


def previews(problem: BakeProblem, run: Run) -> Iterator[Preview]:
    """Bake the previews of a bake, unless the run has kept its traces. Their rays are not counted; errors as those of `bake`."""
    if run.traces and all(run.traces.find(island.trace_key(problem.settings)) for island in problem.islands):
        return
    watching = replace(run, workers=uncounted(run.workers), traces=None, pieces=None)
    islands = [_unmended(island) for island in problem.islands]
    for settings in preview_settings(problem.settings):
        yield Preview(settings, problem.settings.samples, bake(BakeProblem(islands, settings), watching))


def _unmended(island: Island) -> Island:
    """The same, with receivers that know no neighbours."""
    return Island([replace(group, edges=None, faces=None) for group in island.groups], island.occluders)
