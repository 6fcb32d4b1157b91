"""The rows that the panel draws, on a layout that takes notes, because Blender draws none without a window."""

import sys
from functools import partial
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc_blender  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.core import members  # noqa: E402
from paradesc_blender.animation.frame_batch import FrameBatch  # noqa: E402
from paradesc_blender.bake import batch, modal  # noqa: E402
from paradesc_blender.scene import large_faces, mesh_io, record  # noqa: E402
from paradesc_blender.settings import preferences, research  # noqa: E402
from paradesc_blender.ui import (  # noqa: E402
    drawing,
    live_panel,
    looks_panel,
    panel,
    report_panel,
    result,
    settings_panel,
)
from scene import add_sphere, select, small_bake  # noqa: E402

# The width in pixels of a sidebar that nobody has widened.
DEFAULT_WIDTH, SCALE = 217, 2.0
PANELS = [
    cls
    for module in (panel, settings_panel, report_panel)
    for cls in module.classes
    if cls.__name__ != "PARADESC_MT_devices"
]
EVERY_PANEL = [cls for module in paradesc_blender.modules() for cls in module.classes if issubclass(cls, bpy.types.Panel)]
# So many settings are what somebody can look through.
MOST_SETTINGS = 45


@pytest.fixture(autouse=True)
def small(registered):
    small_bake()


class Notes:
    """A layout and all its parts, which notes what is drawn, by kind."""

    def __init__(self, drawn=None):
        kinds = ("label", "prop", "setting", "operator", "menu")
        self.drawn = {kind: [] for kind in kinds} if drawn is None else drawn

    def column(self, **_options):
        return Notes(self.drawn)

    row = split = grid_flow = column

    def label(self, text="", **_options):
        self.drawn["label"].append(text)

    def prop(self, data, name, **_options):
        assert name in data.bl_rna.properties, name
        self.drawn["prop"].append(name)
        self.drawn["setting"].append((data.bl_rna.identifier, name))

    def prop_search(self, data, name, *_where):
        self.prop(data, name)

    def operator_menu_enum(self, name, _member, text="", **_options):
        self.operator(name, text)

    def prop_enum(self, data, name, value, **_options):
        assert value in data.bl_rna.properties[name].enum_items
        self.drawn["prop"].append(value)
        self.drawn["setting"].append((data.bl_rna.identifier, name))

    def operator(self, name, text="", **_options):
        assert hasattr(bpy.types, "PARADESC_OT_" + name.split(".")[1]), name
        self.drawn["operator"].append(text or name)
        return SimpleNamespace()

    def menu(self, name, text="", **_options):
        assert hasattr(bpy.types, name), name
        self.drawn["menu"].append(text)


def context():
    """The context that a panel gets."""
    return SimpleNamespace(
        scene=bpy.context.scene,
        view_layer=bpy.context.view_layer,
        screen=None,
        window_manager=bpy.context.window_manager,
        active_object=bpy.context.active_object,
        selected_objects=bpy.context.selected_objects,
        preferences=SimpleNamespace(
            system=SimpleNamespace(ui_scale=SCALE), ui_styles=[SimpleNamespace(widget=SimpleNamespace(points=11))]
        ),
        region=SimpleNamespace(width=SCALE * DEFAULT_WIDTH),
        space_data=SimpleNamespace(shading=SimpleNamespace(type="SOLID", color_type="VERTEX", light="FLAT")),
    )


def too_wide(labels):
    """The labels that the sidebar cuts, in pixels of Blender's own font."""
    return [text for text in labels if drawing.text_width(context(), text) > drawing.room(context()) and " " in text]


def drawn_by(cls):
    """The rows that a panel, or a menu, draws."""
    layout = Notes()
    fake = SimpleNamespace(layout=layout)
    if hasattr(cls, "draw_settings"):
        fake.draw_settings = partial(cls.draw_settings, fake)
    cls.draw(fake, context())
    return layout.drawn


def drawn_everything(panels=PANELS):
    every = Notes().drawn
    for cls in panels:
        if not hasattr(cls, "poll") or cls.poll(context()):
            for kind, found in drawn_by(cls).items():
                every[kind] += found
    return every


def show_research(monkeypatch, shown=True):
    monkeypatch.setattr(preferences, "shows_research", lambda: shown)


def settings_in_any_state(folder):
    """Our settings that the panels draw in at least one of many states: (group, name) each."""
    scene, found = bpy.context.scene, set()
    settings, looks = scene.paradesc, scene.paradesc_looks

    def look():
        found.update(drawn_everything(EVERY_PANEL)["setting"])

    other, target = add_sphere("other"), add_sphere()
    select(other, target)
    settings.descriptors = {"harris", "cavity"}
    target.shape_key_add(name="Basis")
    target.scale = (2, 1, 1)
    looks.use_neutral, scene.paradesc_animation.use_scene_range = True, False
    look()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    for span in ("auto", "percentile", "fixed"):
        looks.span = span
        look()
    for unit in ("absolute", "mean-edge", "diagonal"):
        settings.radius_unit = unit
        look()
    scene.paradesc_animation.cache_folder, scene.paradesc_live.missing = str(folder), "COMPUTE"
    for mode in ("CACHE", "LIVE"):
        target.paradesc_live.mode, looks.span = mode, "auto"
        assert target.paradesc_live.mode == mode, target.paradesc_live.sentence
        look()
    return {(group, name) for group, name in found if group.startswith("PARADESC_PG_")}


def test_the_panels_draw_few_settings_and_all_of_them_for_research(monkeypatch, tmp_path):
    few = settings_in_any_state(tmp_path)
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    show_research(monkeypatch)
    every = settings_in_any_state(tmp_path)
    sys.stdout.write(f"{len(few)} settings are drawn, {len(every)} with Research Settings\n")
    assert few < every
    assert len(few) <= MOST_SETTINGS
    named = {name for names in research.RESEARCH.values() for name in names}
    assert {name for _, name in every - few} == named  # hidden are those that are named, and no others


def test_research_settings_that_act_are_said_and_go_by_one_click(monkeypatch):
    settings, looks = bpy.context.scene.paradesc, bpy.context.scene.paradesc_looks
    assert "paradesc.reset_research" not in drawn_by(panel.PARADESC_PT_bake)["operator"]
    settings.image_path, looks.neutral = "//elsewhere.exr", 3.0  # no image is written, and no own neutral value is used
    assert research.changed(bpy.context.scene) == []
    settings.seed, settings.estimator = 4, "integral"
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert "2 research settings are set" in " ".join(shown["label"])
    assert {"paradesc.show_research", "paradesc.reset_research"} <= set(shown["operator"])
    settings.estimator = "shape-operator"
    assert "1 research setting is set" in " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])
    show_research(monkeypatch)
    assert "is set" not in " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])
    show_research(monkeypatch, False)
    assert bpy.ops.paradesc.reset_research() == {"FINISHED"}
    assert settings.seed == 0
    assert "is set" not in " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])


def test_the_number_of_a_range_by_percentiles_is_beside_it_and_no_research_setting():
    looks = bpy.context.scene.paradesc_looks
    looks.percentile = 5.0
    assert research.changed(bpy.context.scene) == []
    assert "percentile" not in drawn_by(looks_panel.PARADESC_PT_looks)["prop"]
    looks.span = "percentile"
    assert "percentile" in drawn_by(looks_panel.PARADESC_PT_looks)["prop"]


def test_every_setting_is_in_the_panel(monkeypatch):
    show_research(monkeypatch)
    settings = bpy.context.scene.paradesc
    settings.descriptors = {"harris"}
    settings.backend = "auto"
    add_sphere().shape_key_add(name="Basis")
    shown = set(drawn_everything()["prop"])
    for unit in ("absolute", "mean-edge"):
        settings.radius_unit = unit
        shown |= set(drawn_everything()["prop"])
    defined = {name for group in members.GROUPS for name in group()} - set(members.kept_members())
    assert defined - shown == {"descriptors", "radius_fit", "backend", "device_index"}  # one by one, and as a menu
    assert {"fine", "medium", "broad"} <= shown
    assert {row.name for row in bridge.descriptors()} <= shown


def test_a_button_bakes_one_mesh_onto_another_as_soon_as_two_are_selected():
    add_sphere("fine")
    assert "Bake onto coarse" not in drawn_by(panel.PARADESC_PT_bake)["operator"]
    add_sphere("coarse")
    assert "Bake onto coarse" in drawn_by(panel.PARADESC_PT_bake)["operator"]
    bpy.data.objects["fine"].select_set(False)
    assert "Bake onto coarse" not in drawn_by(panel.PARADESC_PT_bake)["operator"]


def test_three_meshes_are_a_pair_only_where_all_lie_about_the_active_one():
    parts = [add_sphere(name) for name in ("bolts", "body", "coarse")]
    bpy.context.view_layer.update()
    assert "Bake onto coarse" in drawn_by(panel.PARADESC_PT_bake)["operator"]
    parts[0].location.x = 9.0
    bpy.context.view_layer.update()
    shown = drawn_by(panel.PARADESC_PT_bake)["operator"]
    assert "Bake 3 Meshes" in shown
    assert not any(text.startswith("Bake onto") for text in shown)
    assert bpy.ops.paradesc.bake_onto.poll()  # scripts still may


def test_what_is_no_mesh_is_said_to_be_left_out():
    add_sphere()
    for kind in ("FONT", "CURVE"):
        made = bpy.data.objects.new(kind, bpy.data.curves.new(kind, kind))
        bpy.context.collection.objects.link(made)
        made.select_set(True)
    words = " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])
    assert "2 skipped: " in words
    assert {"Text", "Curve"} <= set(words.replace(",", "").split())


def test_an_uneven_scale_is_said_before_a_bake_with_the_button_that_makes_it_count():
    target = add_sphere()
    target.scale = (1, 1, 3)
    bpy.context.view_layer.update()
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert "uneven scale" in " ".join(shown["label"])
    assert "world" in shown["prop"]
    bpy.context.scene.paradesc.space = "world"
    assert "uneven scale" not in " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])


@pytest.mark.parametrize("side", ["dark", "bright"])
def test_a_mask_that_is_white_nearly_everywhere_has_buttons_for_other_radii(monkeypatch, side):
    bpy.context.scene.paradesc.descriptors = {"cavity"}
    target = add_sphere()
    bpy.ops.paradesc.bake()
    stored = record.read(target.data)
    stored["drawn"]["cavity"] |= {"dark": 0.0, "bright": 0.0, side: 0.9}
    monkeypatch.setattr(result, "stored_report", lambda _target: stored)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert ("Most of it is white" in " ".join(shown["label"])) == (side == "bright")
    assert ({"Finer", "Broader"} <= set(shown["operator"])) == (side == "bright")
    assert {"contrast", "brightness", "invert"} <= set(shown["prop"])


def test_the_next_radius_is_a_size_or_half_or_twice_as_large():
    assert result.next_radius("medium", 3.0, -1) == ("fine", 0.0)
    assert result.next_radius("medium", 3.0, 1) == ("broad", 0.0)
    assert result.next_radius("fine", 3.0, -1) == ("panel", 1.5)
    assert result.next_radius("typed", 3.0, 1) == ("panel", 6.0)


def test_of_large_faces_the_button_that_suits_comes_first(monkeypatch):
    bpy.context.scene.paradesc.descriptors = {"cavity"}
    add_sphere()
    buttons = ["Bake Cavity", "Bake to Image"]
    assert [text for text in drawn_by(panel.PARADESC_PT_bake)["operator"] if text in buttons] == buttons
    monkeypatch.setattr(large_faces, "every", lambda _objects, _source: True)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert [text for text in shown["operator"] if text in buttons] == buttons[::-1]
    assert "Faces are too large" in " ".join(shown["label"])


def test_clicks_reach_a_sidebar_alone_while_a_bake_runs():
    region = SimpleNamespace(type="UI", x=1300, y=20, width=200, height=900)
    place = SimpleNamespace(screen=SimpleNamespace(areas=[SimpleNamespace(type="VIEW_3D", regions=[region])]))
    inside, outside = ((1400, 500), (1300, 20)), ((1299, 500), (1500, 500), (1400, 920))
    assert all(modal.over_sidebar(place, SimpleNamespace(mouse_x=x, mouse_y=y)) for x, y in inside)
    assert not any(modal.over_sidebar(place, SimpleNamespace(mouse_x=x, mouse_y=y)) for x, y in outside)


def test_one_scale_is_offered_for_several_meshes_alone():
    first, second = add_sphere("first"), add_sphere("second")
    bpy.ops.paradesc.bake()
    assert "same_scale" in drawn_by(panel.PARADESC_PT_bake)["prop"]
    first.select_set(False)
    assert second == bpy.context.active_object
    assert "same_scale" not in drawn_by(panel.PARADESC_PT_bake)["prop"]


@pytest.mark.parametrize("state", ["nothing", "baked", "uneven", "linked", "dyntopo"])
def test_no_line_is_wider_than_the_sidebar(state, monkeypatch):
    if state != "nothing":
        target = add_sphere()
        bpy.ops.paradesc.bake()
    if state == "uneven":
        target.scale = (2, 1, 1)
        bpy.context.view_layer.update()
    if state == "linked":
        monkeypatch.setattr(mesh_io, "unwritable", refused)
    if state == "dyntopo":
        bpy.ops.object.mode_set(mode="SCULPT")
        bpy.ops.sculpt.dynamic_topology_toggle()
    labels = drawn_everything()["label"]
    assert too_wide(labels) == []


@pytest.mark.parametrize("span", ["auto", "fixed"])
def test_no_line_about_live_values_is_wider_than_the_sidebar(span):
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.more_radii = {"mean_curvature", "sphere_volume_normalized"}, "12.345"
    bpy.context.scene.paradesc_looks.span = span
    target = add_sphere()
    target.paradesc_live.mode = "LIVE"
    labels = drawn_by(live_panel.PARADESC_PT_live)["label"]
    assert target.paradesc_live.sentence == ""
    assert any("computing" in line for line in labels)
    assert too_wide(labels) == []


@pytest.mark.parametrize("kind", ["CLOTH", "SOFT_BODY", "PARTICLE_SYSTEM"])
def test_a_simulation_is_asked_to_be_baked_before_live_values(kind):
    target = add_sphere()
    made = target.modifiers.new("simulated", kind)
    (made if hasattr(made, "point_cache") else target.particle_systems[0]).point_cache.frame_end = 2
    assert live_panel.live_sentence(target) == ""
    target.paradesc_live.mode = "LIVE"
    assert live_panel.live_sentence(target).startswith("Bake the simulation")
    assert bpy.ops.ptcache.bake_all(bake=True) == {"FINISHED"}
    assert live_panel.live_sentence(target) == ""


def refused(target):
    return f'The mesh "{target.data.name}" is linked from another file; make it local first.'


def test_what_stands_in_the_way_is_said_and_linked_meshes_get_a_button(monkeypatch):
    bpy.context.scene.paradesc.descriptors = {"cavity"}
    assert " ".join(drawn_by(panel.PARADESC_PT_bake)["label"]) == "Select a mesh object first"
    add_sphere()
    assert drawn_by(panel.PARADESC_PT_bake)["label"] == []
    monkeypatch.setattr(mesh_io, "unwritable", refused)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert "linked from another file" in " ".join(shown["label"])
    assert "paradesc.make_local" in shown["operator"]


def test_a_missing_library_leaves_one_sentence_and_no_settings(monkeypatch):
    monkeypatch.setattr(bridge, "missing_sentence", lambda: "native library missing – somewhere.")
    shown = drawn_everything()
    assert " ".join(shown["label"]) == "native library missing – somewhere."
    assert shown["prop"] == shown["operator"] == []


@pytest.mark.parametrize("kind", ["bake", "frames"])
def test_a_bake_under_way_shows_how_far_it_is_in_place_of_the_button(monkeypatch, tmp_path, kind):
    add_sphere()
    bpy.context.scene.paradesc_animation.cache_folder = str(tmp_path)
    assert bpy.ops.paradesc.bake.poll()
    assert bpy.ops.paradesc.bake_frames.poll()
    job = batch.Batch(bpy.context) if kind == "bake" else FrameBatch(bpy.context, range(1, 3), tmp_path, beside=True)
    monkeypatch.setattr(modal.ModalJob, "running", job)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert "paradesc_progress" in shown["prop"]
    assert bpy.context.window_manager.paradesc_progress == 0.0
    words = " ".join(shown["label"]).removeprefix("Mean Curvature ")
    frame = {"bake": "", "frames": "frame 1 of 1 to 2, "}[kind]
    assert words == f"Reading the mesh, {frame}0 %"
    assert "Bake Descriptors" not in shown["operator"]
    assert not bpy.ops.paradesc.bake.poll()
    assert not bpy.ops.paradesc.bake_frames.poll()
    assert bpy.ops.paradesc.cancel() == {"FINISHED"}
    assert job.cancelled
    job.close()


def test_last_run_is_there_only_while_the_values_are():
    target = add_sphere()
    assert not report_panel.PARADESC_PT_report.poll(context())
    bpy.ops.paradesc.bake()
    assert report_panel.PARADESC_PT_report.poll(context())
    lines = drawn_by(report_panel.PARADESC_PT_report)["label"]
    for words in ("UV islands: 6", "Coverage: ", "Undefined vertices: 0", "– measuring: ", "llvmpipe"):
        assert any(line.startswith(words) for line in lines), words
    for name in record.attributes_of(target.data):
        target.data.attributes.remove(target.data.attributes[name])
    assert not report_panel.PARADESC_PT_report.poll(context())


def test_devices_that_are_missing_are_in_the_menu_too():
    shown = drawn_by(settings_panel.PARADESC_MT_devices)["operator"]
    assert shown[0] == "Automatic"
    assert [text.split(":")[0] for text in shown[1:]] == ["Graphics Card", "Software", "Reference", "Processor"]
