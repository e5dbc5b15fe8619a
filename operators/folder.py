# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives operators the folder that they read from or write to: from a script, or chosen in the file browser."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, StringProperty

from ..prt_addon.core.errors import PRTError
from ..prt_addon.scene.settings import absolute_path, begin_with_settings


def folder_property(description: str) -> Any:
    """The property `directory` of an operator, which Blender's file browser fills in by this name."""
    return StringProperty(
        name="Folder", description=description, subtype="DIR_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"}
    )


class FolderBrowser:
    """Mixin of operators that read from or write to one folder, their `directory`; a button opens the file browser."""

    if TYPE_CHECKING:
        directory: str

    filter_folder: BoolProperty(  # type: ignore[valid-type]
        name="Show Folders", description="Show folders in the file browser", default=True, options={"HIDDEN"}
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Open the file browser to choose the folder, with the operator's properties beside it."""
        begin_with_settings(self, context.scene)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def _folder(self) -> Path:
        """The folder.

        Raises:
            PRTError: if none was given, or one relative to a file that was never saved.
        """
        if not self.directory:
            raise PRTError("There is no folder to read from or to write to: give its path as 'directory'.")
        return absolute_path(self.directory)
