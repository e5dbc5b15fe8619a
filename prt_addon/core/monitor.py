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
        """All of the work, in rays."""
        return self.rays + self.bounces

    def __add__(self, other: Work) -> Work:
        return Work(self.rays + other.rays, self.bounces + other.bounces)


class Monitor:
    """Watches nothing. Subclasses count what is done, or stop it; they are called in the thread that gives the work."""

    def advance(self, work: Work) -> None:
        """Count work that is done.

        Raises:
            Cancelled: if it is to stop.
        """

    def check_cancelled(self) -> None:
        """Raise an exception if work is to stop; called now and then in work that is not counted.

        Raises:
            Cancelled: if it is to stop.
        """

    def show(self, preview: object) -> None:
        """Show a preview, while the work goes on."""


UNWATCHED = Monitor()
