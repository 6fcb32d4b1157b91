"""Returns whether anything in the panels is cut at the scales of the interface, or any sentence where words are longer.

Blender itself ends a button or a name that is too long with "…"; a sentence has to be seen whole.

Blender draws no panel without a window. A layout that divides widths as Blender does stands in for it, and
panel_in_window.py makes pictures of what it stands for.
"""

from functools import partial
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import longer  # noqa: E402

import paradesc_blender  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.settings import translation  # noqa: E402
from paradesc_blender.ui import drawing  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

DEFAULT_WIDTH = 229  # of a sidebar that nobody has widened, at the scale 1
# The share of a line that Blender gives to a setting's name, and the pixels of an icon or of the arrow of a menu.
LABEL_SHARE, BUTTON_ICON = 0.4, 18
# This one of the descriptors' names ends with "…" in the menu that shows one.
LONGEST = "Principal Curvature, Smaller"
PANELS = [cls for module in paradesc_blender.modules() for cls in module.classes if issubclass(cls, bpy.types.Panel)]


class Layout:
    """A part of a panel: what stands in it, and how it divides its width."""

    def __init__(self, factor=None, across=False, columns=0, split=False):
        self.factor, self.across, self.columns, self.use_property_split = factor, across, columns, split
        self.parts = []

    def part(self, **options):
        self.parts.append(Layout(split=self.use_property_split, **options))
        return self.parts[-1]

    def column(self, **_options):
        return self.part()

    def row(self, **_options):
        return self.part(across=True)

    def split(self, factor=0.5, **_options):
        return self.part(factor=factor)

    def grid_flow(self, columns=1, **_options):
        return self.part(columns=columns)

    def text(self, text, icon="NONE", translate=True, beside=0, sentence=False):
        """Notes a text and what stands beside it; Blender looks up what is not translated yet."""
        shown = longer.lengthened(text) if translate and longer_words else text
        self.parts.append((shown, beside + (icon != "NONE"), sentence))

    def label(self, text="", icon="NONE", translate=True, **_options):
        self.text(text, icon, translate, sentence=not translate)

    def operator(self, name, text=None, icon="NONE", translate=True, **_options):
        own = getattr(bpy.ops.paradesc, name.split(".")[1]).get_rna_type().name
        self.text(own if text is None else text, icon, translate)
        return SimpleNamespace()

    def operator_menu_enum(self, name, _member, text=None, icon="NONE", **_options):
        own = getattr(bpy.ops.paradesc, name.split(".")[1]).get_rna_type().name
        self.text(own if text is None else text, icon, text is None, beside=1)

    def menu(self, _name, text="", icon="NONE", translate=True, **_options):
        self.text(text, icon, translate, beside=1)

    def prop_enum(self, data, name, value, text=None, icon="NONE", translate=True, **_options):
        self.text(data.bl_rna.properties[name].enum_items[value].name if text is None else text, icon, translate)

    def prop_search(self, group, name, *_rest):
        self.prop(group, name)

    def prop(self, group, name, text=None, icon="NONE", translate=True, **_options):
        """Notes the name and the chosen item, each with its share."""
        member = group.bl_rna.properties[name]
        words = member.name if text is None else text
        if member.type == "BOOLEAN":
            self.text(words, "CHECKBOX", translate)
            return
        row = self.part(factor=LABEL_SHARE) if words and self.use_property_split else self
        if words and self.use_property_split:
            row.text(words, translate=translate)
        item = member.enum_items.get(getattr(group, name)) if member.type == "ENUM" else None
        row.text(item.name if item is not None else "0000", beside=1 if item is not None else 0)

    def cut(self, width, unit):
        """The texts that are wider than their part of a width; unit: pixels at the scale 1."""
        small = [isinstance(part, tuple) and not part[0] for part in self.parts]
        small = [
            lone or (isinstance(part, Layout) and part.is_icon()) for lone, part in zip(small, self.parts, strict=True)
        ]
        found = []
        for index, part in enumerate(self.parts):
            own = width
            if self.factor is not None:
                own = width * (self.factor if index == 0 else 1 - self.factor)
            elif self.columns:
                own = width / self.columns
            elif self.across:
                free = width - sum(small) * BUTTON_ICON * unit
                own = free / max(small.count(False), 1)
            if isinstance(part, Layout):
                found += part.cut(own, unit)
            elif (part[2] or not longer_words) and width_of(part[0]) > own - part[1] * BUTTON_ICON * unit:
                found.append(part[0])
        return found

    def is_icon(self):
        """Returns whether nothing but buttons without a text stands here."""
        return bool(self.parts) and all(isinstance(part, tuple) and not part[0] for part in self.parts)


def width_of(text):
    return drawing.text_width(context(), text)


scale, longer_words = 1.0, False


def context():
    widget = SimpleNamespace(widget=SimpleNamespace(points=11))
    return SimpleNamespace(
        scene=bpy.context.scene,
        view_layer=bpy.context.view_layer,
        active_object=bpy.context.active_object,
        selected_objects=bpy.context.selected_objects,
        preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=scale), ui_styles=[widget]),
        region=SimpleNamespace(width=scale * DEFAULT_WIDTH),
        space_data=SimpleNamespace(shading=SimpleNamespace(type="SOLID", color_type="VERTEX", light="FLAT")),
        screen=None,
        window_manager=bpy.context.window_manager,
    )


@pytest.fixture
def words(monkeypatch, request):
    """The scale of the interface, and whether words are longer."""
    monkeypatch.setitem(globals(), "scale", request.param[0])
    monkeypatch.setitem(globals(), "longer_words", request.param[1])
    if request.param[1]:
        monkeypatch.setattr(translation, "look_up", lambda text, _context: longer.lengthened(text))


def drawn(cls):
    """The rows that a panel draws."""
    layout = Layout()
    fake = SimpleNamespace(layout=layout)
    if hasattr(cls, "draw_settings"):
        fake.draw_settings = partial(cls.draw_settings, fake)
    cls.draw(fake, context())
    return layout


def prepare(state):
    """A scene in which the panels have much to say."""
    small_bake()
    settings, looks = bpy.context.scene.paradesc, bpy.context.scene.paradesc_looks
    if state == "new":
        return
    target = add_sphere()
    target.scale = (2, 1, 1)
    target.shape_key_add(name="Basis")
    settings.descriptors, settings.radius_percent = {"principal_curvature_min", "harris"}, 1.0
    bpy.ops.paradesc.bake()
    if state == "sculpting":
        bpy.ops.object.mode_set(mode="SCULPT")
    if state == "live":
        settings.descriptors, looks.span = {"harris"}, "percentile"
        target.paradesc_live.mode = "LIVE"
        bpy.context.scene.paradesc_animation.use_scene_range = False


def panels():
    """The panels that are there, as they are drawn."""
    return {cls.__name__: drawn(cls) for cls in PANELS if not hasattr(cls, "poll") or cls.poll(context())}


STATES = pytest.mark.parametrize("state", ["new", "baked", "sculpting", "live"])


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize("words", [(1.0, False), (1.5, False), (2.0, False), (1.0, True), (2.0, True)], indirect=True)
@STATES
def test_nothing_in_the_panels_is_cut(words, state):
    prepare(state)
    found = {name: layout.cut(drawing.room(context()), scale) for name, layout in panels().items()}
    found["PARADESC_PT_bake"] = [text for text in found["PARADESC_PT_bake"] if text != LONGEST]
    assert {name: texts for name, texts in found.items() if texts} == {}


def texts_of(layout):
    """All texts in a layout."""
    return [text for part in layout.parts for text in (texts_of(part) if isinstance(part, Layout) else [part[0]])]


@pytest.mark.usefixtures("registered")
@STATES
def test_every_text_of_the_panels_is_looked_up_as_it_stands_in_the_code(monkeypatch, state):
    known, unknown = longer.shown() | translation.catalog("de").keys(), []

    def looked_up(text, _context):
        if "«" in text:
            return text  # with parts that were looked up before
        if text not in known:
            unknown.append(text)
        return f"«{text}»"

    prepare(state)
    monkeypatch.setattr(translation, "look_up", looked_up)
    monkeypatch.setattr(drawing, "wrapped", lambda sentence, *_: [sentence])
    shown = [text for layout in panels().values() for text in texts_of(layout)]
    own = {item.name for item in bpy.context.scene.paradesc_looks.bl_rna.properties}
    stored = bpy.context.active_object and record.read(bpy.context.active_object.data)
    allowed = (
        set(stored.get("warnings", "").splitlines() + stored.get("notes", "").splitlines() + [stored["device"]])
        if stored
        else set()
    )
    assert set(unknown) - allowed == set()
    parts = {text for text in shown if "«" in text and not (text[0] == "«" and text[-1] == "»")}
    # The name of a device is no word.
    assert {text for text in parts if not text.startswith(("«Software»: ", "«Graphics Card»: "))} == set()
    static = {text for text in shown if "«" not in text and any(map(str.isalpha, text))}
    assert static - known - own == set()
