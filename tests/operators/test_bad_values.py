# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that no button gives, from scripts, other programs' files, and other people's properties, are one sentence each."""

import numpy as np
import pytest


@pytest.fixture
def ball(blender, scene, stage):
    """A baked ball, active."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ball", stage.icosphere(1), stage.diffuse())
    blender.ops.prt.bake(mode="SHADOWED", samples=8)
    blender.context.view_layer.objects.active = ob
    return ob


def fails(call, said):
    with pytest.raises(RuntimeError, match=said) as raised:
        call()
    assert "Traceback" not in str(raised.value)


def test_cutoffs_that_are_no_numbers(blender, scene, ball):
    scene.prt.window = "HANN"
    for value in (float("nan"),):
        fails(lambda value=value: blender.ops.prt.project_light(cutoff=value), "cutoff is at least 1")


@pytest.mark.parametrize(("index", "count"), [(-1, 2), (2, 2), (0, 0), (0, -3)])
def test_shards_that_do_not_exist(blender, ball, tmp_path, index, count):
    """They were clamped to ones that do, in silence."""
    fails(
        lambda: blender.ops.prt.bake_shard(directory=str(tmp_path), index=index, count=count),
        f"There is no shard {index} of {count}",
    )
    assert not list(tmp_path.iterdir())


def test_a_report_needs_a_name(blender, ball, tmp_path):
    for path in (f"{tmp_path}/", str(tmp_path), f"{tmp_path}/new/"):
        fails(lambda path=path: blender.ops.prt.report(filepath=path, parts={"SAMPLING"}), "is a folder")


@pytest.mark.parametrize("number", ["1e300", "1e39", "-1e20", "nan", "inf"])
def test_numbers_that_layers_cannot_hold(blender, part, ball, tmp_path, number):
    """Infinite in single precision: the mesh keeps its transport."""
    blender.ops.prt.export_games202(directory=str(tmp_path))
    path = tmp_path / "transport.txt"
    lines = path.read_text().splitlines()
    lines[5] = " ".join([number, *lines[5].split()[1:]])
    path.write_text("\n".join(lines))
    before = part("layers").read(ball.data)
    fails(lambda: blender.ops.prt.import_games202(directory=str(tmp_path)), "transport.txt")
    np.testing.assert_array_equal(part("layers").read(ball.data), before)


PARTS = ["prt_turn_x", "prt_strength", "prt_light_0", "prt_light_8"]


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("value", [None, "text", 7, [1.0, 2.0], ["a", "b", "c"]])
def test_half_a_light_is_none(blender, part, scene, ball, tmp_path, name, value):
    """Whoever took parts of it away: it counts as missing, and is made anew."""
    world = scene.world
    if value is None:
        world.driver_remove(f'["{name}"]')
        del world[name]
    elif name == "prt_strength" and isinstance(value, int):
        pytest.skip("a number is a strength")
    else:
        world.driver_remove(f'["{name}"]')
        world[name] = value
    blender.context.view_layer.update()
    scene.frame_set(3)
    assert not part("light").has_light(world) or name in {"prt_turn_x", "prt_strength"}
    scene.prt.auto_light = False
    if not part("light").has_light(world):
        fails(lambda: blender.ops.prt.export_games202(directory=str(tmp_path)), "carries no SH light")
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert part("light").has_light(world)


@pytest.mark.parametrize("change", [{"samples": 2**31 - 1}, {"samples": -1}, {"bounces": 10**6}, {"seed": -4}])
def test_records_of_bakes_that_never_were(blender, part, ball, change):
    """Of unknown origin, and no report casts 16 GiB of rays."""
    record = ball.data["prt_bake"].to_dict()
    ball.data["prt_bake"] = record | change
    [found] = part("freshness").freshness(blender.context, [ball])
    assert found.state == "UNKNOWN"


def test_material_indices_out_of_range(blender, part, ball, stage):
    """A face of material -5, or 99: the first, or the last."""
    indices = np.zeros(len(ball.data.polygons), dtype=np.int32)
    indices[:4] = (-5, 99, 1, 0)
    ball.data.polygons.foreach_set("material_index", np.zeros_like(indices))
    layer = ball.data.attributes.get("material_index") or ball.data.attributes.new("material_index", "INT", "FACE")
    layer.data.foreach_set("value", indices)
    assert blender.ops.prt.bake(samples=8) == {"FINISHED"}


def test_places_that_are_no_numbers(blender, stage, ball):
    """Of any rendered object, baked or not."""
    for name in ("location", "rotation_euler", "scale"):
        ob = stage.object_of(name, stage.cube(), location=(5, 0, 0))
        setattr(ob, name, (float("nan"), 0.0, 0.0))
    ball.select_set(True)
    blender.context.view_layer.update()
    assert blender.ops.prt.bake(samples=8) == {"FINISHED"}
    assert blender.ops.prt.check() == {"FINISHED"}
