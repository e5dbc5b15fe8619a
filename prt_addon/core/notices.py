# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects what a bake reports of objects and materials, and counts it by kind: one sentence for twelve objects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

Level = Literal["WARNING", "INFO"]

_MOST_NAMES = 5


@dataclass(frozen=True)
class Kind:
    """A kind of message about an object or a material.

    Attributes:
        one: the sentence about one of them, with "{name}" and the notice's own details in braces.
        many: the sentence about several, with "{count}" and "{names}".
        level: a WARNING where the result lacks something that was wanted.
        fix: identifier of the operator that may mend it, such as "prt.subdivide"; empty if there is none.
    """

    one: str
    many: str
    level: Level = "WARNING"
    fix: str = ""


@dataclass(frozen=True)
class Notice:
    """A message about one object or material.

    Attributes:
        name: whom it is about.
        details: what else the sentence about a single one needs.
    """

    kind: Kind
    name: str
    details: dict[str, str] = field(default_factory=dict, compare=False)

    @property
    def sentence(self) -> str:
        """The message about this one alone."""
        return self.kind.one.format(name=f"'{self.name}'", **self.details)


@dataclass(frozen=True)
class Counted:
    """All notices of one kind, as one sentence.

    Attributes:
        names: whom it is about.
    """

    kind: Kind
    sentence: str
    names: tuple[str, ...]


def counted(notices: Iterable[Notice]) -> list[Counted]:
    """Count notices by kind: one sentence for each, in the order in which the kinds first appear; warnings come first."""
    kinds: dict[Kind, dict[str, Notice]] = {}
    for notice in notices:
        kinds.setdefault(notice.kind, {}).setdefault(notice.name, notice)
    found = [Counted(kind, _sentence(kind, list(named.values())), tuple(named)) for kind, named in kinds.items()]
    return sorted(found, key=lambda one: one.kind.level != "WARNING")


def listed(names: Iterable[str]) -> str:
    """Some names in quotes, the first few of many."""
    quoted = [f"'{name}'" for name in names]
    more = len(quoted) - _MOST_NAMES
    return ", ".join(quoted[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _sentence(kind: Kind, notices: list[Notice]) -> str:
    if len(notices) == 1:
        return notices[0].sentence
    return kind.many.format(count=len(notices), names=listed(notice.name for notice in notices))
