# SPDX-License-Identifier: GPL-3.0-or-later
"""The PRT tab of the 3D View's sidebar, which every panel here belongs to."""


class Tab:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "PRT"
