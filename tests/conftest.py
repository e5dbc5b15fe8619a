# SPDX-License-Identifier: GPL-3.0-or-later
"""Enables the real extension in the real Blender once per session, and gives each test an empty file."""

import importlib

import pytest

from tests.handles import WHERE

pytest_plugins = ["failed_pictures"]


@pytest.fixture(scope="session")
def blender():
    """bpy with the checkout enabled as `bl_ext.dev.prt_relight`."""
    import headless

    headless.enable_extension()
    import bpy

    yield bpy
    headless.disable_extension()


@pytest.fixture(scope="session")
def part(blender):
    """Import a module of the extension under the name that Blender gave it: `part("light")`."""
    import headless

    return lambda name: importlib.import_module(f"{headless.PACKAGE}.prt_addon.{WHERE[name]}")


@pytest.fixture
def coarse(part, monkeypatch):
    """Worlds are looked at by panoramas of 64 rows, quickly; a list of the skies that were."""
    full, skies = part("panorama").panorama, []

    def look(sky, height=64):
        skies.append(sky)
        return full(sky, min(height, 64))

    monkeypatch.setattr(part("projection"), "panorama", look)
    return skies


@pytest.fixture
def scene(blender):
    """The scene of an empty file; the extension stays enabled."""
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return blender.context.scene


@pytest.fixture
def stage(scene):
    """The stage hands' module, which can be imported once Blender runs."""
    from tests import stage

    return stage


@pytest.fixture
def stage_under_sky(stage):
    """The same, once a sky of six colours lights the scene."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    return stage
