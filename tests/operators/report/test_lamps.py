# SPDX-License-Identifier: GPL-3.0-or-later
"""What `bpy.ops.prt.report` says of suns and lamps: how much of the light they are, and what is lost with and without them."""

import re
from itertools import pairwise

import numpy as np
import pytest

from tests.core import skies

LAMPS = {"city": 2, "courtyard": 4, "forest": 4, "interior": 4, "night": 3, "studio": 4, "sunrise": 2, "sunset": 2}
"""How many of them *Automatic* finds in the HDRIs that Blender ships."""


@pytest.fixture
def photograph(blender, stage):
    """A ball over a floor, under an HDRI that Blender ships; the ball is selected."""

    def load(name):
        import headless

        stage.environment(blender.data.images.load(str(headless.studio_hdri(name))))
        ob = stage.object_of("Knot", stage.icosphere(3), stage.diffuse())
        stage.object_of("Floor", stage.grid(2, 3.0), None, (0, 0, -1.0))
        ob.select_set(True)

    return load


def test_sun_of_closed_form(blender, stage, report):
    """A disc in a grey sky, turned and scaled, over a lone ball: its share, and what order 2 loses of it."""
    pixels = skies.with_disc(256, (1.0, 2.0, 0.5), 0.01, 1e5)
    _, mapping = stage.environment(stage.picture("Sun", pixels), strength=0.7)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    stage.object_of("Ball", stage.icosphere(4), stage.diffuse()).select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    document = report(points=2048, paths=64, parts={"TRUNCATION"})
    assert document["lamps"]["share_of_light"] == pytest.approx(skies.share_of_disc(0.01, 1e5), rel=0.01)
    assert document["lamps"]["count"] == 1
    coarse = skies.with_disc(64, (1.0, 2.0, 0.5), 0.01, 1e5)  # sends the same to a surface
    for order, wanted in skies.losses(coarse, coarse, (1, 2, 4)).items():
        found = document["all"]["truncation"]["by_order"][str(order)]
        assert found["low"] < wanted < found["high"], order


@pytest.mark.parametrize(
    "name",
    [
        "sunset",
        "studio",
        *(pytest.param(name, marks=pytest.mark.slow) for name in sorted(LAMPS.keys() - {"sunset", "studio"})),
    ],
)
def test_lamps_of_photographs_are_told(blender, scene, photograph, report, name):
    """And the truth has converged under them: its 95 % interval is under 2 %."""
    photograph(name)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    document = report(paths=256)
    truncation = document["all"]["truncation"]
    assert truncation["reference_interval"] < 0.02 and truncation["reference_converged"]
    count = LAMPS[name]
    assert re.match(rf"{count} lamps carry \d.*%.* and show it in EEVEE", document["all"]["advice"]["truncation"])
    assert scene.world["prt_light"]["lamp_count"] == document["lamps"]["count"] == count and document["lamps"]["shown"]
    assert document["lamps"]["share_of_light"] > 0.05
    assert truncation["without_lamps"]["value"] < 0.8 * truncation["by_order"]["2"]["value"]
    losses = [truncation["by_order"][str(order)]["value"] for order in range(1, 7)]
    assert all(later < 1.1 * earlier for earlier, later in pairwise(losses)) and losses[1] > 0.01


@pytest.mark.parametrize(("lamps", "count", "shown"), [("NONE", 4, False), ("ONE", 1, True), ("AUTO", 4, True)])
def test_lamps_are_those_that_light_or_could(blender, photograph, report, lamps, count, shown):
    """As the light was projected with; *Automatic*'s where none light."""
    photograph("studio")
    blender.ops.prt.bake(mode="SHADOWED", samples=16, lamps=lamps)
    document = report(parts={"TRUNCATION"})
    assert (document["lamps"]["count"], document["lamps"]["shown"]) == (count, shown)
    said = {"NONE": "4 lamps would carry 87% of", "ONE": "1 lamp carries ", "AUTO": "4 lamps carry 87% of"}[lamps]
    assert document["all"]["advice"]["truncation"].startswith(said)
    assert ("Extract Lamps would leave" in document["all"]["advice"]["truncation"]) != shown


def test_a_sun_disc_is_told_however_faint(blender, scene, stage, report):
    """EEVEE does not show it but by its lamp, which the projection therefore takes out in any case."""
    world, _ = stage.environment(stage.picture("Grey", np.full((8, 16, 3), 0.5, dtype=np.float32)))
    sky = world.node_tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "MULTIPLE_SCATTERING" if blender.app.version >= (5, 0, 0) else "NISHITA"
    sky.sun_disc, sky.sun_elevation, sky.sun_intensity = True, 1.5, 0.0005
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    world.node_tree.links.new(sky.outputs[0], background.inputs["Color"])
    stage.object_of("Ball", stage.icosphere(3), stage.diffuse()).select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16, lamps="AUTO")
    document = report(parts={"TRUNCATION"})
    assert document["lamps"]["count"] == scene.world["prt_light"]["lamp_count"] == 1
    assert 0.0 < document["lamps"]["share_of_light"] < 0.02 and document["lamps"]["shown"]
