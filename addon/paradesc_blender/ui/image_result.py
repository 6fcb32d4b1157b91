"""Draws what the last bake to images made of the chosen mesh, and the buttons that show it."""

import bpy

from ..scene import image_preview, image_results, targets
from ..scene.image_results import ImageBake
from ..settings.translation import label
from .drawing import sentence_lines
from .result import draw_extremes


def draw(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws the images of the last bake with their buttons; nothing if none was baked, or if all are deleted."""
    target = targets.first(context)
    made = image_results.found(target)
    if made is None:
        return
    column, images = layout.column(align=True), made.images
    sentence_lines(context, column, result_sentence(made))
    shown = image_preview.shown(target)
    for image in filter(image_preview.can_show, images):
        text = label("Show on Mesh") if len(images) == 1 else made.label(image)
        options = {"icon": "HIDE_OFF" if image.name == shown else "HIDE_ON", "depress": image.name == shown}
        column.operator("paradesc.show_image", text=text, translate=False, **options).name = image.name
    opened = next((image for image in images if image.name == shown), images[0])
    row = column.row(align=True)
    row.operator("paradesc.open_image", text=label("Open"), translate=False).name = opened.name
    if images[0].packed_file is not None or len(images[0].packed_files):
        row.operator("paradesc.save_images", text=label("Save"), translate=False).name = opened.name
    else:
        row.operator("paradesc.open_image_folder", text=label("Folder"), translate=False).name = opened.name
    operator = "paradesc.bake_onto" if made.cage else "paradesc.bake_image"
    draw_extremes(context, column, made.extremes(opened), made.percent, (operator, {*made.held(opened)}))
    for kind, sentences in (("INFO", made.notes), ("ERROR", made.warnings)):
        for sentence in sentences.splitlines():
            sentence_lines(context, column, sentence, kind)


def result_sentence(made: ImageBake) -> str:
    """One line that names the baked images, their size and the time."""
    images = made.images
    what = images[0].name if len(images) == 1 else label("{count} images").format(count=len(images))
    return label("{what}, {size}², {seconds} s").format(what=what, size=made.size, seconds=f"{made.seconds:.1f}")
