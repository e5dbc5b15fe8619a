# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps animated values that a user has changed and not keyed yet: evaluating the frame anew would throw them away.

What the viewport shows is what counts: a pose, or a lamp, that was moved by hand is read there, and stays there.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isclose

import bpy


@dataclass(frozen=True)
class _Unkeyed:
    """One value that is not what its curve says."""

    owner: bpy.types.ID
    curve: bpy.types.FCurve
    value: float | int | bool

    def restore(self) -> None:
        """Set it again."""
        path = self.curve.data_path
        found = self.owner.path_resolve(path, False)
        if isinstance(found, bpy.types.bpy_prop_array):
            found[self.curve.array_index] = self.value
        elif path.endswith('"]'):  # a custom property
            found.data[path[path.rindex('["') + 2 : -2]] = self.value
        else:
            setattr(found.data, path.rpartition(".")[2], self.value)


@contextmanager
def unkeyed_values(context: bpy.types.Context) -> Iterator[None]:
    """Keep such values while frames are evaluated inside."""
    found = list(_unkeyed(context.scene.frame_current_final))
    for one in found:
        one.curve.mute = True
    try:
        yield
    finally:
        for one in found:
            one.curve.mute = False
        if found:
            context.view_layer.update()  # follows the curves once more
            for one in found:
                one.restore()
            context.view_layer.update()


def _unkeyed(frame: float) -> Iterator[_Unkeyed]:
    for owner, animation in _animated():
        for curve in _curves(animation):
            value = _value(owner, curve)
            if value is not None and not curve.mute and not _same(value, curve.evaluate(frame)):
                yield _Unkeyed(owner, curve, value)


def _animated() -> Iterator[tuple[bpy.types.ID, bpy.types.AnimData]]:
    """All data-blocks whose action decides on their values, and node trees inside of others."""
    for collection in bpy.data.bl_rna.properties:
        if collection.type != "COLLECTION":
            continue
        for block in getattr(bpy.data, collection.identifier):
            for one in (block, getattr(block, "node_tree", None)):
                animation = getattr(one, "animation_data", None)
                if animation and animation.action and not animation.nla_tracks:
                    yield one, animation


def _curves(animation: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """The curves of an action that are meant for its user: since 4.4 one action may serve several."""
    slot = animation.action_slot
    for layer in animation.action.layers if slot else ():
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            if bag:
                yield from bag.fcurves


def _value(owner: bpy.types.ID, curve: bpy.types.FCurve) -> float | int | bool | None:
    """What the animated property is now; None if there is none, or it is no number."""
    try:
        value = owner.path_resolve(curve.data_path)
        if not isinstance(value, (bool, int, float)):
            value = value[curve.array_index]
    except (ValueError, TypeError, IndexError, KeyError):
        return None
    return value if isinstance(value, (bool, int, float)) else None


def _same(value: float | int | bool, curve: float) -> bool:
    """A number, or what is stored of it: booleans and integers hold no fractions."""
    if isinstance(value, (bool, int)):
        return int(value) in {int(curve), round(curve)} or bool(value) == bool(curve)
    return isclose(value, curve, rel_tol=1e-5, abs_tol=1e-6)
