"""Finds the F-curves that animate a datablock, in layered actions and in those before Blender 4.4."""

from collections.abc import Iterator

import bpy


def curves_of(animation: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """The F-curves with keyframes, from the action or its strips."""
    strips = (strip.action for track in animation.nla_tracks for strip in track.strips)
    for action in filter(None, (animation.action, *strips)):
        if getattr(action, "layers", None):
            bags = (bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags)
        else:
            bags = (action,)
        for bag in bags:
            yield from bag.fcurves
