"""Makes copies of objects with their modifiers applied and with all values, on request."""

import bpy

from ..scene import delivery
from ..settings.translation import said
from . import recolor


class PARADESC_OT_make_result_object(recolor.NeedsBake, bpy.types.Operator):
    """Make a copy with all modifiers applied and every mask on its vertices; it is selected, and the original hidden"""

    bl_idname = "paradesc.make_result_object"
    bl_label = "Copy with Values"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only in object mode, where the selection can change."""
        return context.mode == "OBJECT" and super().poll(context)

    def run(self, context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes one copy and hides its original in the viewport and in renders."""
        copy = delivery.copy_with_values(target)
        if context.view_layer.objects.active == target:
            context.view_layer.objects.active = copy
        copy.select_set(True)
        target.select_set(False)
        target.hide_set(True)
        target.hide_render = True
        names = {"copy": copy.name, "name": target.name}
        sentence = said('"{copy}" has the modifiers applied and all masks; "{name}" is hidden')
        self.report({"INFO"}, sentence.format(**names))


classes = (PARADESC_OT_make_result_object,)
