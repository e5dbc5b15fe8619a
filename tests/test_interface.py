# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface keeps Blender's habits: tooltips, presets, keyframes, a menu, settings that stay, undo."""

import ast
import importlib
from pathlib import Path
from types import SimpleNamespace

import pytest


@pytest.fixture
def classes(blender):
    """All registered classes of the extension."""
    import headless

    bases = (getattr(blender.types, name) for name in ("Operator", "Panel", "Menu", "PropertyGroup"))
    found = [cls for base in bases for cls in base.__subclasses__() if cls.__module__.startswith(headless.PACKAGE)]
    return [cls for cls in found if cls.is_registered]


@pytest.fixture
def panel(blender):
    """Import a module of the interface: `panel("bake")`."""
    import headless

    return lambda name: importlib.import_module(f"{headless.PACKAGE}.ui.{name}")


def operators(blender, classes):
    """Each operator's class and what Blender has registered of it."""
    for cls in classes:
        if issubclass(cls, blender.types.Operator):
            yield cls, getattr(blender.ops.prt, cls.bl_idname.removeprefix("prt.")).get_rna_type()


def test_everything_has_a_tooltip(blender, classes):
    """Operators, panels, menus, every property, and every item to choose."""
    assert len(classes) > 15
    holders = [cls.bl_rna for cls in classes if issubclass(cls, blender.types.PropertyGroup)]
    for cls, rna in operators(blender, classes):
        assert rna.description and not rna.description.endswith("."), cls
        holders.append(rna)
    for cls in classes:
        assert getattr(cls, "bl_description", "") or cls.__doc__, cls  # Blender shows the one or the other
    explained = 0
    for holder in holders:
        for prop in holder.properties:
            if prop.is_runtime and not prop.is_hidden:
                explained += 1
                assert prop.description, f"{holder.identifier}.{prop.identifier}"
                for item in getattr(prop, "enum_items", ()):
                    assert item.description, f"{holder.identifier}.{prop.identifier}: {item.identifier}"
    assert explained > 15


def test_menu_offers_every_operator(blender, classes, panel):
    """F3 finds what is in a menu; nothing but helpers of a panel is kept out of it."""
    import headless

    entries = [draw.__module__ for draw in blender.types.VIEW3D_MT_object.draw._draw_funcs]
    assert entries.count(f"{headless.PACKAGE}.ui.menu") == 1
    internal = {cls.bl_idname for cls, _ in operators(blender, classes) if "INTERNAL" in getattr(cls, "bl_options", ())}
    assert internal <= {"prt.cancel", "prt.keep_preview", "prt.bake_preset_add", "prt.select_noticed"}
    offered = [name for group in panel("menu").GROUPS for name, _ in group]
    offered[offered.index("PRT_MT_skies")] = "prt.use_sky"  # a submenu of one operator's choices
    assert sorted(offered) == sorted({cls.bl_idname for cls, _ in operators(blender, classes)} - internal)


def test_icons_exist(blender, panel):
    """Blender draws a panel or menu no further than to an icon that it does not know."""
    icons = blender.types.UILayout.bl_rna.functions["operator"].parameters["icon"].enum_items
    assert all(icon in icons for group in panel("menu").GROUPS for _, icon in group)


def test_file_menus_offer_imports_and_exports(blender, classes, panel):
    """Every operator that reads or writes another program's file stands in File > Import or Export, once."""
    import headless

    drawn = []
    layout = SimpleNamespace(operator=lambda name, text: drawn.append((name, text)))
    for menu in (blender.types.TOPBAR_MT_file_import, blender.types.TOPBAR_MT_file_export):
        ours = [draw for draw in menu.draw._draw_funcs if draw.__module__ == f"{headless.PACKAGE}.ui.file_menus"]
        assert len(ours) == 1
        ours[0](SimpleNamespace(layout=layout), blender.context)
    wanted = {cls.bl_idname for cls, _ in operators(blender, classes)}
    wanted = {name for name in wanted if name.startswith(("prt.import_", "prt.export_"))}
    assert sorted(name for name, _ in drawn) == sorted(wanted) and all(text for _, text in drawn)


def test_what_changes_data_can_be_undone(blender, classes):
    """All but looking, writing files, and what only touches the interface."""
    changes_nothing = (
        "prt.cancel",
        "prt.keep_preview",
        "prt.check",
        "prt.copy_info",
        "prt.export",
        "prt.bake_preset_add",
        "prt.bake_shard",
    )
    for cls, _ in operators(blender, classes):
        can_be_undone = "UNDO" in getattr(cls, "bl_options", ())
        assert can_be_undone != cls.bl_idname.startswith(changes_nothing), cls.bl_idname


def test_what_takes_long_is_not_done_again_by_the_redo_panel(blender, classes):
    """It would show defaults in place of the scene's settings, and work in the foreground at every touch."""
    long = {"prt.bake", "prt.bake_stale", "prt.bake_shard", "prt.merge_shards", "prt.report"}
    found: dict[str, set[str]] = {
        cls.bl_idname: getattr(cls, "bl_options", set()) for cls, _ in operators(blender, classes)
    }
    assert not any("REGISTER" in found[name] for name in long)


@pytest.fixture
def settings(blender):
    import headless

    return importlib.import_module(f"{headless.PACKAGE}.prt_addon.scene.settings")


def mixins(settings):
    """Those of settings that operators take, derived ones first."""
    found = [cls for name, cls in vars(settings).items() if isinstance(cls, type) and name.endswith("Properties")]
    return sorted(found, key=lambda cls: -len(cls.__mro__))


def test_what_takes_settings_has_no_redo_panel(blender, classes, settings):
    """It would show defaults in place of the scene's, which are what is used."""
    takes = [cls for cls, _ in operators(blender, classes) if issubclass(cls, tuple(mixins(settings)))]
    assert len(takes) > 8
    assert [cls.bl_idname for cls in takes if "REGISTER" in getattr(cls, "bl_options", ())] == []


def other_value(prop):
    """One that a property does not begin with."""
    if prop.type == "ENUM":
        return next(item.identifier for item in prop.enum_items if item.identifier != prop.default)
    return "other" if prop.type == "STRING" else prop.default + 1


def test_dialogs_begin_with_the_scenes_settings(blender, scene, settings):
    """All of them, of whatever kind, and those that are given as they are given."""
    assert set(settings._stored_settings(scene)) == set(mixins(settings))
    shown = {}

    class PRT_OT_shows(*mixins(settings), blender.types.Operator):  # type: ignore[misc, name-defined]  # of a fixture
        bl_idname, bl_label = "prt.shows", "Shows"

        def execute(self, context):
            settings.begin_with_settings(self, context.scene)
            shown.update({name: getattr(self, name) for mixin in mixins(settings) for name in mixin.__annotations__})
            return {"FINISHED"}

    for mixin, stored in settings._stored_settings(scene).items():
        for name in mixin.__annotations__:
            setattr(stored, name, other_value(stored.bl_rna.properties[name]))
    wanted = {
        name: getattr(stored, name)
        for mixin, stored in settings._stored_settings(scene).items()
        for name in mixin.__annotations__
    }
    blender.utils.register_class(PRT_OT_shows)
    try:
        blender.ops.prt.shows()
        assert shown == wanted and wanted["lamps"] == "NONE"
        blender.ops.prt.shows(lamps="AUTO", samples=3)
        assert shown == wanted | {"lamps": "AUTO", "samples": 3}
    finally:
        blender.utils.unregister_class(PRT_OT_shows)


def test_every_dialog_begins_with_settings():
    """Whatever opens one: in background Blender opens none, so that the functions are read."""
    opening = {"invoke_props_dialog", "fileselect_add"}
    found = []
    for path in sorted((Path(__file__).parents[1] / "operators").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                calls = [
                    ast.unparse(one.func).rpartition(".")[2] for one in ast.walk(node) if isinstance(one, ast.Call)
                ]
                if opening & set(calls):
                    found.append(node.name)
                    assert "begin_with_settings" in calls, f"{path.name}: {node.name}"
    assert len(found) == 2


def test_settings_can_be_keyframed_and_stay_with_their_scene(blender, scene, tmp_path):
    """Right-click > Insert Keyframe; another scene has its own; a saved file keeps them."""
    scene.prt.samples = 32
    assert scene.prt.keyframe_insert("samples", frame=1)
    scene.prt.samples = 64
    assert scene.prt.keyframe_insert("samples", frame=11)
    scene.frame_set(6)
    assert scene.prt.samples == 48
    other = blender.data.scenes.new("Other")
    assert other.prt.samples == 256
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert blender.data.scenes["Scene"].prt.samples == 48
    assert blender.data.scenes["Other"].prt.samples == 256


def run_preset(blender, name):
    path = blender.utils.preset_find(name, "prt/bake")
    assert blender.ops.script.execute_preset(filepath=path, menu_idname="PRT_PT_bake_presets") == {"FINISHED"}


def test_presets(blender, scene):
    """What is shipped costs more and more; people add theirs, and cannot lose ours."""
    costs = []
    for name in ("Draft", "Good", "Final"):
        run_preset(blender, name)
        costs.append(scene.prt.samples)
    assert costs == sorted(set(costs))
    run_preset(blender, "Good")
    for prop in scene.prt.bl_rna.properties:
        if prop.is_runtime and prop.type != "POINTER":
            assert getattr(scene.prt, prop.identifier) == prop.default, "a new scene starts with Good"

    scene.prt.mode, scene.prt.seed = "SHADOWED", 5
    assert blender.ops.prt.bake_preset_add(name="Mine") == {"FINISHED"}
    run_preset(blender, "Final")
    run_preset(blender, "Mine")
    assert (scene.prt.mode, scene.prt.seed) == ("SHADOWED", 5)
    assert blender.ops.prt.bake_preset_add(name="Mine", remove_name=True) == {"FINISHED"}
    assert blender.utils.preset_find("Mine", "prt/bake") is None
    assert blender.ops.prt.bake_preset_add(name="Draft", remove_name=True) == {"CANCELLED"}
    assert blender.utils.preset_find("Draft", "prt/bake")


def test_the_panel_says_what_will_be_baked(blender, scene, stage, panel):
    """As the bake chooses: neither probes nor what is no mesh counts."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light()
    blender.ops.prt.show_light(kind="PROBE")
    objects = [stage.object_of(name, stage.cube()) for name in ("One", "Two")]
    objects.append(stage.object_of("Nothing", None))
    said = panel("bake").what_is_baked
    assert said(blender.context) == "All meshes that render"
    for ob in scene.objects:
        ob.select_set(True)
    assert said(blender.context) == "2 selected meshes"
    objects[0].select_set(False)
    assert said(blender.context) == "1 selected mesh"
    for number in range(100):
        stage.object_of(f"More {number}", objects[0].data).select_set(True)
    assert said(blender.context) == "More than 100 selected meshes"


def test_the_panel_says_which_settings_were_changed(blender, scene, stage, panel):
    """Only where it matters: the cutoff does to two of the windows."""
    changed = panel("light").changed_settings
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    scene.prt.window = "HANN"
    assert changed(scene) == []
    blender.ops.prt.project_light()
    assert changed(scene) == []
    scene.prt.cutoff = 3.7
    assert changed(scene) == ["Cutoff"]
    scene.prt.window, scene.prt.lamps = "LANCZOS", "NONE"
    assert changed(scene) == ["Window", "Cutoff", "Extract Lamps"]
    blender.ops.prt.project_light()
    assert changed(scene) == []
    scene.prt.window = "NONE"
    assert changed(scene) == ["Window"]
    blender.ops.prt.project_light()
    scene.prt.cutoff = 5.0
    assert changed(scene) == []


def test_what_is_greyed_out_says_why(blender, part, scene, stage):
    """A poll that fails leaves a sentence, for scripts as for the tooltip."""
    with pytest.raises(RuntimeError, match="No bake is running"):
        blender.ops.prt.cancel()
    stage.object_of("Ball", stage.icosphere(5))
    settings = part("problem").BakeSettings(samples=1 << 14)
    plan = part("read").read_bake(blender.context, list(scene.objects), settings)
    job = part("job").bake_job(plan.problem, threads=2)
    job.start()
    with pytest.raises(RuntimeError, match="A bake is running"):
        blender.ops.prt.bake()
    job.cancel()
    job.wait()
