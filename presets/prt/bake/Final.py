# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.prt

settings.mode = "INTERREFLECTED"
settings.samples = 1024
settings.bounces = 3
settings.tolerance = 0.001
