"""The parts that the tests of preset files share: a valid preset, files made of it, and a folder of the user's own."""

import json

import bpy

from paradesc_blender.settings import preset_folders

SOUND = {
    "paradesc_preset": 1,
    "name": "Studio Cavity",
    "purpose": "The mask for dirt of every prop",
    "settings": {"descriptors": ["cavity", "convexity"], "radius_percent": 1.1, "samples": 99, "more_radii": "3, 4"},
    "colors": {"color_map": "heat", "span": "fixed", "minimum": -0.5, "maximum": 0.75, "symmetric": False},
    "image": {"image_format": ".png", "texels": 2048},
}


def written(folder, file="preset.json", /, **changes):
    """A sound preset with changes; those that are None are left out."""
    content = {**SOUND, **changes}
    path = folder / file
    path.write_text(json.dumps({key: value for key, value in content.items() if value is not None}))
    return path


def own_folder(monkeypatch, tmp_path):
    """Makes an empty folder that takes the place of the user's own presets."""
    folder = tmp_path / "user" / "presets" / preset_folders.SUBFOLDER
    folder.mkdir(parents=True)
    monkeypatch.setattr(bpy.utils, "user_resource", lambda _kind, path="", create=False: str(tmp_path / "user" / path))
    monkeypatch.setattr(bpy.utils, "preset_paths", lambda _path: [str(folder)])
    return folder
