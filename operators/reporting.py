# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns the engine's exceptions into what Blender shows: one sentence, and a cancelled operator."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TypeVar

import bpy

from ..prt_addon.core.errors import Cancelled, PRTError

Operator = TypeVar("Operator", bound=bpy.types.Operator)
Method = Callable[[Operator, bpy.types.Context], set[str]]


def reports_errors(method: Method[Operator]) -> Method[Operator]:
    """Wrap an operator's method: a PRTError becomes a report and `{'CANCELLED'}`.

    From a script, Blender turns the ERROR report into a RuntimeError; a cancel is no error.
    """

    @functools.wraps(method)
    def guarded(self: Operator, context: bpy.types.Context) -> set[str]:  # Blender counts the arguments
        try:
            return method(self, context)
        except Cancelled as stop:
            self.report({"WARNING"}, str(stop))
        except PRTError as error:
            self.report({"ERROR"}, str(error))
        except OSError as error:  # a file or folder of the user's
            self.report({"ERROR"}, f"'{error.filename}' cannot be used: {error.strerror}.")
        return {"CANCELLED"}

    return guarded
