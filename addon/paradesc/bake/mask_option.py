"""A mask as an option of operators that bake."""

import bpy

from ..settings import presets
from .fit import PANEL


class MaskOption:
    """An operator that menus ask for one mask, which then is the panel's too."""

    mask: bpy.props.EnumProperty(
        name="Mask",
        description="What to bake: a mask, or what the panel has",
        items=[PANEL, *((name, presets.PRESETS[name].label, presets.PRESETS[name].purpose) for name in presets.MASKS)],
        default=PANEL[0],
        options={"SKIP_SAVE"},
    )

    def take_mask(self, group: bpy.types.PropertyGroup) -> None:
        """Chooses the mask that was given."""
        if self.mask != PANEL[0]:
            presets.choose_mask(group, self.mask)
