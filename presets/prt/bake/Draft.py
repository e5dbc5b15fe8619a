# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.prt

settings.mode = "INTERREFLECTED"
settings.samples = 64
settings.bounces = 1
settings.tolerance = 0.0
