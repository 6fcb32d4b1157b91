"""What the panel draws, on a layout that takes notes, because Blender draws none without a window."""

from functools import partial
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.animation.frame_batch import FrameBatch  # noqa: E402
from paradesc.bake import batch, modal  # noqa: E402
from paradesc.core import members  # noqa: E402
from paradesc.scene import mesh_io, record  # noqa: E402
from paradesc.ui import drawing, image_panel, live_panel, panel, report_panel, settings_panel  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

# The width in pixels of a sidebar that nobody has widened.
DEFAULT_WIDTH, SCALE = 217, 2.0
PANELS = [
    cls
    for module in (panel, settings_panel, report_panel, image_panel)
    for cls in module.classes
    if cls.__name__ != "PARADESC_MT_devices"
]


@pytest.fixture(autouse=True)
def small(registered):
    small_bake()


class Notes:
    """A layout and all its parts, which notes what is drawn, by kind."""

    def __init__(self, drawn=None):
        self.drawn = {"label": [], "prop": [], "operator": [], "menu": [], "progress": []} if drawn is None else drawn

    def column(self, **_options):
        return Notes(self.drawn)

    row = split = grid_flow = column

    def label(self, text="", **_options):
        self.drawn["label"].append(text)

    def prop(self, data, name, **_options):
        assert name in data.bl_rna.properties, name
        self.drawn["prop"].append(name)

    def operator_menu_enum(self, name, _member, text="", **_options):
        self.operator(name, text)

    def prop_enum(self, data, name, value, **_options):
        assert value in data.bl_rna.properties[name].enum_items
        self.drawn["prop"].append(value)

    def operator(self, name, text="", **_options):
        assert hasattr(bpy.types, "PARADESC_OT_" + name.split(".")[1]), name
        self.drawn["operator"].append(text or name)
        return SimpleNamespace()

    def prop_menu_enum(self, data, name, **_options):
        self.prop(data, name)

    def menu(self, name, text="", **_options):
        assert hasattr(bpy.types, name), name
        self.drawn["menu"].append(text)

    def progress(self, **options):
        self.drawn["progress"].append(options["factor"])


def context():
    """The context that a panel gets."""
    return SimpleNamespace(
        scene=bpy.context.scene,
        view_layer=bpy.context.view_layer,
        screen=None,
        active_object=bpy.context.active_object,
        selected_objects=bpy.context.selected_objects,
        preferences=SimpleNamespace(
            system=SimpleNamespace(ui_scale=SCALE), ui_styles=[SimpleNamespace(widget=SimpleNamespace(points=11))]
        ),
        region=SimpleNamespace(width=SCALE * DEFAULT_WIDTH),
        space_data=SimpleNamespace(shading=SimpleNamespace(type="SOLID", color_type="VERTEX")),
    )


def too_wide(labels):
    """The labels that the sidebar cuts, in pixels of Blender's own font."""
    return [text for text in labels if drawing.text_width(context(), text) > drawing.room(context()) and " " in text]


def drawn_by(cls):
    """What a panel, or a menu, draws."""
    layout = Notes()
    fake = SimpleNamespace(layout=layout)
    if hasattr(cls, "draw_settings"):
        fake.draw_settings = partial(cls.draw_settings, fake)
    cls.draw(fake, context())
    return layout.drawn


def drawn_everything():
    every = Notes().drawn
    for cls in PANELS:
        if not hasattr(cls, "poll") or cls.poll(context()):
            for kind, found in drawn_by(cls).items():
                every[kind] += found
    return every


def test_every_setting_is_in_the_panel():
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.write_image, settings.write_buffers = {"harris"}, True, True
    add_sphere().shape_key_add(name="Basis")
    shown = set(drawn_everything()["prop"])
    for unit in ("absolute", "mean-edge"):
        settings.radius_unit = unit
        shown |= set(drawn_everything()["prop"])
    defined = {name for group in members.GROUPS for name in group()}
    assert defined - shown == {"descriptors", "backend", "device_index"}  # one by one, and as a menu
    assert {row.name for row in bridge.descriptors()} <= shown


def test_a_button_bakes_one_mesh_onto_another_as_soon_as_two_are_selected():
    add_sphere("fine")
    assert "Bake onto coarse" not in drawn_by(panel.PARADESC_PT_bake)["operator"]
    add_sphere("coarse")
    assert "Bake onto coarse" in drawn_by(panel.PARADESC_PT_bake)["operator"]
    bpy.data.objects["fine"].select_set(False)
    assert "Bake onto coarse" not in drawn_by(panel.PARADESC_PT_bake)["operator"]


@pytest.mark.parametrize("state", ["nothing", "baked", "uneven", "linked", "dyntopo"])
def test_no_line_is_wider_than_the_sidebar(state, monkeypatch):
    if state != "nothing":
        target = add_sphere()
        bpy.ops.paradesc.bake()
    if state == "uneven":
        target.scale = (2, 1, 1)
        bpy.context.view_layer.update()
    if state == "linked":
        monkeypatch.setattr(mesh_io, "check_writable", refused)
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
    raise bridge.ParadescError(3, f'The mesh "{target.data.name}" is linked from another file; make it local first.')


def test_what_stands_in_the_way_is_said_and_linked_meshes_get_a_button(monkeypatch):
    bpy.context.scene.paradesc.descriptors = {"cavity"}
    assert " ".join(drawn_by(panel.PARADESC_PT_bake)["label"]) == "Select a mesh object first"
    add_sphere()
    assert drawn_by(panel.PARADESC_PT_bake)["label"] == []
    monkeypatch.setattr(mesh_io, "check_writable", refused)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert "linked from another file" in " ".join(shown["label"])
    assert "Make Meshes Local" in shown["operator"]


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
    assert shown["progress"] == [0.0]
    words = " ".join(shown["label"]).removeprefix("Mean Curvature ")
    assert words == {"bake": "read, 0%", "frames": "frame 1 of 1 to 2, read, 0%"}[kind] + " (Esc cancels)"
    assert "Bake Descriptors" not in shown["operator"]
    assert not bpy.ops.paradesc.bake.poll()
    assert not bpy.ops.paradesc.bake_frames.poll()
    job.close()


def test_last_run_is_there_only_while_the_values_are():
    target = add_sphere()
    assert not report_panel.PARADESC_PT_report.poll(context())
    bpy.ops.paradesc.bake()
    assert report_panel.PARADESC_PT_report.poll(context())
    lines = drawn_by(report_panel.PARADESC_PT_report)["label"]
    for words in ("UV islands: 6", "Coverage: ", "Undefined vertices: 0", "– evaluate: ", "llvmpipe"):
        assert any(line.startswith(words) for line in lines), words
    for name in record.attributes_of(target.data):
        target.data.attributes.remove(target.data.attributes[name])
    assert not report_panel.PARADESC_PT_report.poll(context())


def test_devices_that_are_missing_are_in_the_menu_too():
    shown = drawn_by(settings_panel.PARADESC_MT_devices)["operator"]
    assert shown[0] == "Automatic"
    assert [text.split(":")[0] for text in shown[1:]] == ["Graphics Card", "Software", "Reference", "Processor"]
