"""Installs, uses, updates and disables the add-on for install_test.py, in another Blender with empty user folders.

Usage: blender -b --factory-startup -P install_in_blender.py -- ACTION ARGUMENT...
       python install_in_blender.py -- ACTION ARGUMENT...                           with the Python module bpy
"""

import gc
import itertools
import os
import statistics
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

from allocator import give_back, megabytes_in_use

LEGACY = "paradesc_blender"
EXTENSION = "bl_ext.user_default.paradesc"
REMOTE = "bl_ext.paradesc_releases.paradesc"
USER = Path(os.environ["PARADESC_TEST_USER"])
CYCLES = 100 if os.environ.get("PARADESC_LONG_TESTS") else 32
# The first rounds fill caches of Blender, the driver and Python.
FIRST_CYCLES = 8
# The memory that is held repeats after four rounds.
PERIOD = 4
# Megabytes for each round: at most 0.008 and 0.03 were seen in 40 runs on a busy machine. A baked mesh with its reports
# is 0.1, a context that stays, with its buffers and programs, 10.
MOST_GROWTH = {"heap": 0.03, "resident": 0.3}
# Settings that a user chose, one of each kind: number, text, choice, several choices, and a member of another group.
CHOSEN = {"samples": 97, "more_radii": "7, 9", "normals": "max", "descriptors": {"curvedness", "harris"}}
CHOSEN_LOOK = {"color_map": "purple-green"}
PRESET_SAMPLES = 41


def finished(result: set[str]) -> None:
    """Fails if an operator did not finish."""
    assert result == {"FINISHED"}, result


def enable(module: str) -> None:
    """Enables the add-on; before, nothing of it was there."""
    finished(bpy.ops.preferences.addon_enable(module=module))
    assert hasattr(bpy.types.Scene, "paradesc")


def disable(module: str) -> None:
    """Disables the add-on; nothing of it stays."""
    finished(bpy.ops.preferences.addon_disable(module=module))
    assert not hasattr(bpy.types.Scene, "paradesc")
    assert not hasattr(bpy.types, "PARADESC_PT_bake")
    assert not hasattr(bpy.types, "PARADESC_OT_bake")


def bake(backend: str = "software") -> None:
    """Adds a torus, bakes it, and looks at the values: a torus is most curved on its outer equator."""
    bpy.ops.mesh.primitive_torus_add(generate_uvs=True, major_segments=24, minor_segments=12)
    torus = bpy.context.active_object
    settings = bpy.context.scene.paradesc
    settings.backend = backend
    settings.buffer_size = 256
    settings.descriptors = {"mean_curvature"}
    finished(bpy.ops.paradesc.bake())
    values = [row.value for row in torus.data.attributes["mean_curvature"].data]
    assert len(values) == 24 * 12
    assert 1.0 < max(values) < 3.5, max(values)  # 0.5 (1/0.25 + 1/1.25) = 2.4, on a coarse mesh
    assert "mean_curvature_color" in torus.data.attributes
    mesh = torus.data
    bpy.data.objects.remove(torus)
    bpy.data.meshes.remove(mesh)


def install_legacy(package: str) -> None:
    """Installs as under Preferences > Add-ons > Install."""
    finished(bpy.ops.preferences.addon_install(filepath=package, overwrite=True))


def install_extension(package: str) -> None:
    """Installs as under Preferences > Get Extensions > Install from Disk."""
    import addon_utils

    addon_utils.enable("bl_pkg")
    finished(bpy.ops.extensions.package_install_files(filepath=package, repo="user_default", enable_on_install=True))


def refused(package: str) -> None:
    """Tries to install the zip of another system, which Blender refuses by an error, or only on its output."""
    try:
        install_extension(package)
    except (AssertionError, RuntimeError) as error:
        sys.stdout.write(f"{error}\n")
    assert not hasattr(bpy.types.Scene, "paradesc")


def legacy(package: str) -> None:
    """Installs the zip into the add-ons folder and uses it."""
    install_legacy(package)
    use(LEGACY)


def extension(package: str) -> None:
    """Installs the zip as an extension and uses it."""
    install_extension(package)
    assert hasattr(bpy.types.Scene, "paradesc")
    disable(EXTENSION)
    use(EXTENSION)


def use(module: str) -> None:
    """Enables, bakes, disables."""
    enable(module)
    assert str(Path(sys.modules[module].__file__)).startswith(str(USER))
    bake()
    disable(module)


def remote(index: str) -> None:
    """Installs from a repository as Blender's button does."""
    place = add_repository(index)
    finished(bpy.ops.extensions.package_install(repo_index=place, pkg_id="paradesc", enable_on_install=True))
    bake()


def add_repository(index: str) -> int:
    """Adds a repository as under Preferences > Get Extensions > Repositories > +; gives its place in the list."""
    import addon_utils

    addon_utils.enable("bl_pkg")
    bpy.context.preferences.system.use_online_access = True
    repositories = bpy.context.preferences.extensions.repos
    repositories.new(name="Paradesc", module="paradesc_releases", remote_url=index)
    place = len(repositories) - 1
    finished(bpy.ops.extensions.repo_sync(repo_index=place))
    return place


def upgrade_remote(index: str, newer: str) -> None:
    """Updates from a repository that has a newer version, as Blender's button does."""
    remote(index)
    choose()
    repositories = bpy.context.preferences.extensions.repos
    repositories[-1].remote_url = newer
    finished(bpy.ops.extensions.repo_sync(repo_index=len(repositories) - 1))
    finished(bpy.ops.extensions.package_upgrade_all())
    is_newer_with_older_package(REMOTE)


def upgrade_extension(package: str, newer: str) -> None:
    """Installs a newer extension zip from disk over one in use."""
    install_extension(package)
    bake()
    choose()
    install_extension(newer)
    is_newer_with_older_package(EXTENSION)


def upgrade_legacy(package: str, newer: str) -> None:
    """Installs a newer zip over one in use."""
    install_legacy(package)
    enable(LEGACY)
    bake()
    choose()
    install_legacy(newer)
    # The boxes in the preferences: off, on.
    disable(LEGACY)
    finished(bpy.ops.preferences.addon_enable(module=LEGACY))
    is_newer_with_older_package(LEGACY)


def choose() -> None:
    """Makes a preset, and chooses settings in the open file, which is saved."""
    scene = bpy.context.scene
    scene.paradesc.samples = PRESET_SAMPLES
    finished(bpy.ops.paradesc.add_preset(name="Mine"))
    for group, chosen in ((scene.paradesc, CHOSEN), (scene.paradesc_looks, CHOSEN_LOOK)):
        for name, value in chosen.items():
            setattr(group, name, value)
    bpy.ops.wm.save_as_mainfile(filepath=str(USER / "chosen.blend"))


def has_chosen() -> None:
    """Checks that the settings are as the user left them."""
    scene = bpy.context.scene
    for group, chosen in ((scene.paradesc, CHOSEN), (scene.paradesc_looks, CHOSEN_LOOK)):
        found = {name: getattr(group, name) for name in chosen}
        assert found == chosen, found


def is_newer_with_older_package(module: str) -> None:
    """Checks that the add-on is of version 9.9.9, and says what to do about the package, which stays as it was loaded."""
    assert sys.modules[module].__version__ == sys.modules[module].FRESH == "9.9.9"
    sentence = sys.modules[f"{module}.ui.failure"].sentence[0]
    assert "9.9.9" in sentence
    assert "restart Blender" in sentence, sentence
    assert hasattr(bpy.types, "PARADESC_PT_failure")
    assert not hasattr(bpy.types, "PARADESC_PT_bake")
    bpy.ops.wm.save_userpref()


def after_restart(module: str) -> None:
    """Checks after an update and a restart that file and preset are as the user left them, and that it bakes."""
    if not bpy.app.binary_path:  # the Python module bpy, other than the program, starts without the user's preferences
        if module == REMOTE:
            bpy.context.preferences.extensions.repos.new(name="Paradesc", module="paradesc_releases")
        enable(module)
    assert sys.modules[module].__version__ == "9.9.9"
    finished(bpy.ops.wm.open_mainfile(filepath=str(USER / "chosen.blend")))
    has_chosen()
    (preset,) = (path for folder in bpy.utils.preset_paths("paradesc") for path in Path(folder).glob("[Mm]ine.json"))
    finished(bpy.ops.paradesc.load_preset(filepath=str(preset)))
    assert bpy.context.scene.paradesc.samples == PRESET_SAMPLES
    bake()


def cycles(package: str) -> None:
    """Enables, bakes and disables again and again; later rounds leave nothing that the first ones did not leave."""
    install_legacy(package)
    counts = []
    for _ in range(CYCLES):
        enable(LEGACY)
        bake()
        disable(LEGACY)
        gc.collect()
        counts.append(holdings())
    sys.stdout.write("".join(f"{count}\n" for count in counts))
    settled, last = counts[FIRST_CYCLES], counts[-1]
    for name in ("files", "libraries", "threads", "handlers"):
        assert last[name] <= settled[name], (name, counts)
    for name, most in MOST_GROWTH.items():
        grown = growth([count[name] for count in counts[FIRST_CYCLES:]])
        sys.stdout.write(f"{name}: {grown:.3f} MB a round\n")
        assert grown < most, (name, counts)


def growth(megabytes: list[float]) -> float:
    """Megabytes for each round, of what later rounds do not give back: resident memory also rises and falls by pages.

    The median, since a leak grows in every round, and a list or an arena only in one.
    """
    kept = list(itertools.accumulate(reversed(megabytes), min))[::-1]
    return statistics.median((late - early) / PERIOD for early, late in zip(kept[:-PERIOD], kept[PERIOD:], strict=True))


def holdings() -> dict[str, float]:
    """The things in this process that an add-on can leak."""
    give_back()
    status = Path("/proc/self/status").read_text()
    maps = Path("/proc/self/maps").read_text().splitlines()
    lists = [
        value
        for value in (getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers))
        if isinstance(value, list)
    ]
    return {
        "files": len(list(Path("/proc/self/fd").iterdir())),
        "libraries": len({line.split(maxsplit=5)[-1] for line in maps if ".so" in line}),
        "threads": len(list(Path("/proc/self/task").iterdir())),
        "handlers": sum(map(len, lists)),
        "heap": megabytes_in_use(),
        "resident": int(status.split("VmRSS:")[1].split()[0]) / 1024,
    }


def is_source(folder: str) -> bool:
    """Returns whether Python would find an add-on there that was not installed."""
    return (Path(folder) / "paradesc").is_dir()


def main() -> None:
    """Runs one action; --python-exit-code makes Blender end with an error."""
    # A development environment has the sources on Python's path, from where the add-on must not be taken.
    sys.path[:] = [folder for folder in sys.path if USER in Path(folder).parents or not is_source(folder)]
    action, *arguments = sys.argv[sys.argv.index("--") + 1 :]
    globals()[action](*arguments)
    sys.stdout.write(f"{action} done\n")
    sys.stdout.flush()


main()
