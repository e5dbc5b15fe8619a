# SPDX-License-Identifier: GPL-3.0-or-later
"""Watches work that takes long: counts how much is done, and stops it when the user cancels."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Work:
    """An amount of work.

    Attributes:
        rays: to cast.
        bounces: of light, as the number of rays that take as long.
    """

    rays: int = 0
    bounces: int = 0

    @property
    def total(self) -> int:
        """All of it, in rays."""
        return self.rays + self.bounces

    def __add__(self, other: Work) -> Work:
        return Work(self.rays + other.rays, self.bounces + other.bounces)


class Monitor:
    """Watches nothing. Others count what is done, or stop it: both methods are called in the thread that gives the work."""

    def advance(self, work: Work) -> None:
        """Some work is done.

        Raises:
            Cancelled: if it is to stop.
        """

    def check_cancelled(self) -> None:
        """Called now and then in work that is not counted.

        Raises:
            Cancelled: if it is to stop.
        """

    def show(self, preview: object) -> None:
        """There is something to look at, though the work goes on."""


UNWATCHED = Monitor()
