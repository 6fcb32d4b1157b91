"""The buttons below Bake to Image: its texture on the mesh, in an image editor, in its folder, or as a file."""

from pathlib import Path

import bpy

from ..scene import image_preview, image_results, targets
from ..scene.image_results import ImageBake
from ..settings.translation import can_run, said, tooltip


class OfImage:
    """Base of the operators on an image that was baked from the active mesh."""

    name: bpy.props.StringProperty(
        name="Image", description="Image to show; the first if none is named", default="", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a baked image of the active mesh."""
        return can_run(cls, "" if image_results.found(targets.first(context)) else "Bake this mesh to an image first")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Finds the image and passes it to run(), which subclasses define."""
        made = image_results.found(targets.first(context))
        image = next((image for image in made.images if image.name == self.name), made.images[0])
        return self.run(context, made, image)


class PARADESC_OT_show_image(OfImage, bpy.types.Operator):
    """Show the image on the mesh in solid viewports, or stop showing it; your materials are not changed"""

    bl_idname = "paradesc.show_image"
    bl_label = "Show on Mesh"

    def run(self, context: bpy.types.Context, made: ImageBake, image: bpy.types.Image) -> set[str]:
        """Shows the image on the mesh, or hides it if it is shown there."""
        target, shading = targets.first(context), getattr(context.space_data, "shading", None)
        solid = shading is None or shading.type == "SOLID"
        if image_preview.shown(target) == image.name and solid:
            image_preview.hide(target)
            return {"FINISHED"}
        if not image_preview.can_show(image):
            self.report({"ERROR"}, said("Viewports show no tiles in this way; add the image to a material"))
            return {"CANCELLED"}
        if not solid:
            shading.type = "SOLID"
        image_preview.show(target, image, made.uv_map, made.cage)
        return {"FINISHED"}


class PARADESC_OT_open_image(OfImage, bpy.types.Operator):
    """Show the image in an open image editor, or else in a new window"""

    bl_idname = "paradesc.open_image"
    bl_label = "Open"

    def run(self, context: bpy.types.Context, _made: ImageBake, image: bpy.types.Image) -> set[str]:
        """Shows the image in an image editor, in a new window if none is open."""
        windows = context.window_manager.windows
        areas = (area for window in windows for area in window.screen.areas)
        area = next((area for area in areas if area.ui_type == "IMAGE_EDITOR"), None)
        if area is None:
            before = set(windows)
            bpy.ops.wm.window_new()
            area = next(window for window in windows if window not in before).screen.areas[0]
            area.ui_type = "IMAGE_EDITOR"
        area.spaces.active.image = image
        area.tag_redraw()
        return {"FINISHED"}


class PARADESC_OT_open_image_folder(OfImage, bpy.types.Operator):
    """Open the folder of the image's file"""

    bl_idname = "paradesc.open_image_folder"
    bl_label = "Folder"

    def run(self, _context: bpy.types.Context, _made: ImageBake, image: bpy.types.Image) -> set[str]:
        """Opens the image's folder in the system's file browser."""
        folder = image_results.folder_of(image)
        if not folder.is_dir():
            self.report({"ERROR"}, said("There is no folder {folder}").format(folder=folder))
            return {"CANCELLED"}
        open_folder(folder)
        return {"FINISHED"}


def open_folder(folder: Path) -> None:
    """Opens a folder in the system's file browser."""
    bpy.ops.wm.path_open(filepath=str(folder))


class PARADESC_OT_save_images(OfImage, bpy.types.Operator):
    """Write the images that are packed into the .blend as PNG files into a folder"""

    bl_idname = "paradesc.save_images"
    bl_label = "Save"

    directory: bpy.props.StringProperty(
        name="Folder",
        description="Folder of the files; the folder of the .blend if empty",
        default="",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
    filter_folder: bpy.props.BoolProperty(
        name="Folders", description="Have the file browser show folders", default=True, options={"HIDDEN", "SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Asks for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, _context: bpy.types.Context, made: ImageBake, _image: bpy.types.Image) -> set[str]:
        """Writes all images of the bake to the folder; existing files are kept."""
        directory = self.directory or "//"
        if directory.startswith("//") and not bpy.data.filepath:
            self.report({"ERROR"}, said("Save the .blend first, because images go beside it, or choose a folder"))
            return {"CANCELLED"}
        folder = Path(bpy.path.abspath(directory))
        contents = {
            folder / name: content
            for image in made.images
            for name, content in image_results.packed_files(image).items()
        }
        if not contents:
            self.report({"ERROR"}, said("No image of this mesh is packed into the .blend; its images are files"))
            return {"CANCELLED"}
        taken = next((path for path in contents if path.exists()), None)
        try:
            if taken is not None:
                raise FileExistsError(17, tooltip("it exists already"), str(taken))
            for path, content in contents.items():
                path.write_bytes(content)
        except OSError as error:
            sentence = said("The file {path} cannot be written: {reason}")
            self.report({"ERROR"}, sentence.format(path=error.filename, reason=error.strerror))
            return {"CANCELLED"}
        self.report({"INFO"}, said("Wrote {path}").format(path=", ".join(map(str, contents))))
        return {"FINISHED"}


classes = (PARADESC_OT_show_image, PARADESC_OT_open_image, PARADESC_OT_open_image_folder, PARADESC_OT_save_images)
