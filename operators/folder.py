# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing a folder: in the file browser, or by a script."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty


class FolderBrowser:
    """Mixin of operators that read from or write to one folder."""

    directory: StringProperty(  # type: ignore[valid-type]
        name="Folder", description="Folder to read from or to write to", subtype="DIR_PATH"
    )
    filter_folder: BoolProperty(  # type: ignore[valid-type]
        name="Show Folders", description="Show folders in the file browser", default=True, options={"HIDDEN"}
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def _folder(self) -> Path:
        return Path(bpy.path.abspath(self.directory))
