"""Presets for common purposes, which take one click each, and presets of the user and of a studio's shared folder.

They are applied to a scene, and made from a scene's settings.
"""

from collections.abc import Iterable
from pathlib import Path

import bpy

from paradesc import bridge
from paradesc.bridge import InputError, ParadescError
from paradesc.core.members import Member
from paradesc.files import preset_file, preset_rules
from paradesc.files.preset_file import Content
from paradesc.files.preset_rules import PRESETS

from . import preset_folders, translation

# The file of the preset that was chosen last, if it is not a built-in one.
chosen: list[Path] = []
MASKS = ("cavity", "edge_wear", "curvature", "openness")


def items_of(names: Iterable[str]) -> list[tuple[str, str, str]]:
    """Menu items (name, label, tooltip) of built-in presets."""
    return [(name, PRESETS[name].name, PRESETS[name].purpose) for name in names]


def descriptors_of(masks: Iterable[str]) -> set[str]:
    """The descriptors of these masks."""
    return {descriptor for mask in masks for descriptor in PRESETS[mask].settings["descriptors"]}


def masks_of(descriptors: set[str]) -> list[str]:
    """The masks with exactly these descriptors; empty if there are others among them."""
    found = [mask for mask in MASKS if descriptors_of([mask]) <= descriptors]
    return found if descriptors_of(found) == descriptors else []


def choose_mask(group: bpy.types.PropertyGroup, name: str, extend: bool = False) -> None:
    """Chooses a mask, or switches it beside the others; other settings stay. A fitted radius follows from the mask."""
    masks = [name]
    if extend:
        others = masks_of(group.descriptors)
        left = [mask for mask in others if mask != name]
        masks = (left or masks) if name in others else [*others, name]
    group.descriptors = descriptors_of(masks)
    show_chosen(PRESETS[name].name)


def apply(scene: bpy.types.Scene, content: Content, path: Path | None = None) -> None:
    """Applies a valid preset. Settings and colors that it does not name get their defaults; images keep theirs.

    A value is set only if it differs, because setting a color makes live values recolor. path: its file, if it has one.
    """
    known = preset_rules.rules()
    if content.settings is not None:
        for name in known["settings"]:
            scene.paradesc.property_unset(name)
        set_members(scene.paradesc, {"radius_fit": "typed", **content.settings}, known["settings"])
    if content.colors is not None:
        whole = preset_rules.completed(content.colors, known["colors"])
        set_members(scene.paradesc_looks, whole, known["colors"])
    if content.image is not None:
        set_members(scene.paradesc, content.image, known["image"])
    show_chosen(content.name, path)


def set_members(group: bpy.types.PropertyGroup, values: dict[str, object], known: dict[str, Member]) -> None:
    """Sets the values that differ. radius_fit comes last, because setting a radius marks it as typed."""
    kept = preset_rules.as_kept(values, known)
    for name in sorted(kept, key="radius_fit".__eq__):
        if getattr(group, name) != kept[name]:
            setattr(group, name, kept[name])


def show_chosen(label: str, path: Path | None = None) -> None:
    """Shows the label of the preset that was chosen last, and keeps its file for the button that removes it."""
    PARADESC_MT_presets.bl_label = label
    chosen[:] = [path] if path else []


class NeedsLibrary:
    """Base of operators that need the native library, because its descriptors are chosen."""

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Works only if the native library is available."""
        return not bridge.missing_sentence()

    def done(self, sentence: str) -> set[str]:
        """Ends the operator, with one sentence about a failure or with ""."""
        if sentence:
            self.report({"ERROR"}, translation.said(sentence))
        return {"CANCELLED"} if sentence else {"FINISHED"}


class Chooses(NeedsLibrary):
    """Base of operators on a built-in preset of a given name, which choose() applies in part or as a whole."""

    @classmethod
    def description(cls, _context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """The purpose of the preset, as a tooltip."""
        return translation.tooltip(PRESETS[asked.name].purpose)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Applies the preset, and says what it is for."""
        preset = PRESETS[self.name]
        self.choose(context.scene, preset)
        self.report({"INFO"}, f"{translation.label(preset.name)}: {translation.said(preset.purpose)}")
        return {"FINISHED"}


class PARADESC_OT_preset(Chooses, bpy.types.Operator):
    """Set descriptors, radius, quality and colors for a purpose"""

    bl_idname = "paradesc.preset"
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: bpy.props.EnumProperty(name="Preset", description="Purpose of the settings", items=items_of(PRESETS))

    def choose(self, scene: bpy.types.Scene, preset: Content) -> None:
        """Applies all of it; device and output stay."""
        apply(scene, preset)


class PARADESC_OT_mask(Chooses, bpy.types.Operator):
    """Choose the mask that is baked; a radius that was typed stays. Shift-click bakes several"""

    bl_idname = "paradesc.mask"
    bl_label = "Choose Mask"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: bpy.props.EnumProperty(name="Mask", description="Purpose of the values", items=items_of(MASKS))
    extend: bpy.props.BoolProperty(
        name="Extend", description="Keep the other masks", default=False, options={"SKIP_SAVE"}
    )

    @classmethod
    def description(cls, context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """The purpose of the mask, and how to bake several, as a tooltip."""
        return f"{super().description(context, asked)}.\n{translation.tooltip('Shift-click bakes several masks')}"

    def choose(self, scene: bpy.types.Scene, _preset: Content) -> None:
        """Chooses this mask alone, or switches it in addition to others."""
        choose_mask(scene.paradesc, self.name, self.extend)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Runs the operator; with Shift it switches the mask."""
        self.extend = event.shift
        return self.execute(context)


class PARADESC_OT_load_preset(NeedsLibrary, bpy.types.Operator):
    """Set what a preset file says, which is checked first and never executed"""

    bl_idname = "paradesc.load_preset"
    bl_label = "Load Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: bpy.props.StringProperty(name="File", description="The preset, a JSON file", subtype="FILE_PATH")

    @classmethod
    def description(cls, _context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """The purpose of the preset, or the reason why it cannot be used, as a tooltip."""
        path = Path(asked.filepath)
        rows = [row for row in preset_folders.rows_in(path.parent) if row.path == path]
        sentence = rows[0].fault or rows[0].purpose if rows else ""
        return translation.tooltip(sentence.rstrip(".") or cls.__doc__)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Applies the preset if all of it is valid; otherwise changes nothing."""
        path = Path(bpy.path.abspath(self.filepath))
        try:
            content = preset_rules.sound(path)
        except ParadescError as error:
            return self.done(error.sentence)
        apply(context.scene, content, path)
        self.report({"INFO"}, f"{content.name}: {content.purpose}".rstrip(": "))
        return {"FINISHED"}


class PARADESC_MT_presets(bpy.types.Menu):
    """Settings for a purpose"""

    bl_idname = "PARADESC_MT_presets"
    bl_label = "Presets"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws the built-in presets, the user's own, those of shared folders, and the entries to add or remove one."""
        for name, preset in PRESETS.items():
            self.layout.operator("paradesc.preset", text=translation.label(preset.name), translate=False).name = name
        for folder in (preset_folders.own_folder(), *preset_folders.shared_folders()):
            rows = preset_folders.rows_in(folder)
            if rows:
                self.layout.separator()
            for row in rows:
                line = self.layout.row()
                line.enabled = not row.fault
                line.operator("paradesc.load_preset", text=row.name).filepath = str(row.path)
        self.layout.separator()
        save, take_away = translation.label("Save as Preset…"), translation.label("Remove This Preset")
        self.layout.operator("paradesc.add_preset", text=save, translate=False, icon="ADD")
        remove = self.layout.row()
        remove.enabled = bool(chosen)
        button = remove.operator("paradesc.add_preset", text=take_away, translate=False, icon="REMOVE")
        button.remove_active = True


class PARADESC_OT_add_preset(NeedsLibrary, bpy.types.Operator):
    """Save these settings as a preset, or remove the preset that was chosen last"""

    bl_idname = "paradesc.add_preset"
    bl_label = "Add Preset"
    bl_options = {"REGISTER", "INTERNAL"}

    name: bpy.props.StringProperty(
        name="Name",
        description="Name of the preset in the menu",
        maxlen=preset_file.LONGEST_NAME,
        options={"SKIP_SAVE"},
    )
    purpose: bpy.props.StringProperty(
        name="Purpose",
        description="Purpose of the preset, for its tooltip; may be left empty",
        maxlen=preset_file.LONGEST_PURPOSE,
        options={"SKIP_SAVE"},
    )
    remove_name: bpy.props.BoolProperty(
        name="Remove by Name",
        description="Remove the preset of your own that has this name",
        default=False,
        options={"HIDDEN", "SKIP_SAVE"},
    )
    remove_active: bpy.props.BoolProperty(
        name="Remove the Last",
        description="Remove the preset that was chosen last, if it is your own",
        default=False,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Asks for the name of a new preset."""
        if self.remove_name or self.remove_active:
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Saves or removes a preset."""
        try:
            if self.remove_name or self.remove_active:
                remove(self.name if self.remove_name else "")
            else:
                add(context.scene, self.name.strip(), self.purpose.strip())
        except ParadescError as error:
            return self.done(error.sentence)
        except OSError as error:
            return self.done(f"The folder of presets cannot be changed: {error.strerror or error}.")
        return self.done("")


def add(scene: bpy.types.Scene, name: str, purpose: str) -> None:
    """Saves a scene's settings as a preset of the user."""
    if not name:
        raise InputError("Give the preset a name.")
    folder = preset_folders.own_folder(create=True)
    if folder is None:
        raise InputError("Blender has no user folder for presets.")
    path = preset_file.place_of(folder, name)
    groups = {"settings": scene.paradesc, "colors": scene.paradesc_looks, "image": scene.paradesc}
    sections = {
        section: {member: preset_rules.plain(getattr(groups[section], member)) for member in known}
        for section, known in preset_rules.rules().items()
    }
    content = Content(name, purpose, **sections)
    preset_rules.check(path, content)
    preset_file.write(path, content)
    show_chosen(name, path)


def remove(name: str) -> None:
    """Removes a preset of the user by name, or the one chosen last."""
    own = preset_folders.own_folder()
    paths = [row.path for row in preset_folders.rows_in(own) if row.name == name] if name else chosen
    if not paths:
        what = f'There is no preset "{name}" of your own.'
        raise InputError(what if name else "Choose a preset of your own first.")
    path = paths[0]
    if own is None or not preset_folders.same_place(path.parent, own):
        raise InputError(f'"{path.name}" is not one of your presets, so it is not removed.')
    path.unlink(missing_ok=True)
    if path in chosen:
        show_chosen("Presets")


classes = (PARADESC_OT_preset, PARADESC_OT_mask, PARADESC_OT_load_preset, PARADESC_MT_presets, PARADESC_OT_add_preset)


def unregister() -> None:
    """Forgets which preset was chosen last."""
    show_chosen("Presets")
