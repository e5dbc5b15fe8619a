# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the parts of the extension lie that tests take hold of: the one place that a move has to change.

`part("light")` imports one under the name that Blender gave it. Tests of the engine alone import `prt_addon.core` as it is.
"""

WHERE = {
    "bake": "core.bake.bake",
    "cube_map": "core.sky.cube_map",
    "cycles_colour": "scene.material.cycles_colour",
    "equirect_projection": "core.sky.projection",
    "errors": "core.errors",
    "freshness": "scene.bake.freshness",
    "gather": "scene.bake.gather",
    "glances": "glances",
    "handlers": "handlers",
    "heat_map": "scene.mesh.heat_map",
    "images": "scene.blender.images",
    "job": "worker.job",
    "layers": "scene.mesh.layers",
    "light": "scene.light.light",
    "light_picture": "scene.light.picture",
    "light_state": "scene.light.state",
    "material_reading": "scene.material.reading",
    "nodes": "scene.blender.nodes",
    "panorama": "scene.sky.panorama",
    "prepare": "scene.bake.prepare",
    "preview": "core.sky.preview",
    "problem": "core.problem",
    "projection": "scene.sky.projection",
    "raycast": "core.transport.raycast",
    "record": "scene.mesh.record",
    "relight_group": "scene.shading.relight_group",
    "rotation": "core.sphere.rotation",
    "settings": "scene.settings",
    "sh": "core.sphere.sh",
    "shading": "scene.shading.shading",
    "sky": "scene.sky.sky",
    "trace": "core.bake.trace",
    "whole_bake": "scene.bake.whole_bake",
    "window": "core.sphere.window",
}
