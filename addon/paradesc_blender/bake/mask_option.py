"""A mask as an option of operators that bake."""

import bpy

from ..settings import presets
from .fit import PANEL


class MaskOption:
    """Adds a mask option to an operator, so that menus can run it for one mask. The panel's mask then follows."""

    mask: bpy.props.EnumProperty(
        name="Mask",
        description="Mask to bake, or the descriptors of the panel",
        items=[PANEL, *((name, presets.PRESETS[name].label, presets.PRESETS[name].purpose) for name in presets.MASKS)],
        default=PANEL[0],
        options={"SKIP_SAVE"},
    )

    def take_mask(self, group: bpy.types.PropertyGroup) -> None:
        """Sets the panel's mask to the operator's."""
        if self.mask != PANEL[0]:
            presets.choose_mask(group, self.mask)
