"""The manual: short or complete as it promises, and no link, picture or command that leads nowhere."""

import re
import struct
from dataclasses import fields
from importlib.util import find_spec
from types import SimpleNamespace

import pytest

from paradesc import bridge
from shapes import ADDON, ROOT

MANUAL = ADDON / "manual"
PICTURES = MANUAL / "pictures"
REFERENCE = MANUAL / "reference.md"
CHANGES = ADDON / "CHANGELOG.md"
ENDINGS = ("png", "jpg", "gif")
FOLDERS = ("addon", "blend_samples", "native", "tests")
IN_BLENDER = pytest.mark.skipif(find_spec("bpy") is None, reason="needs Blender")
HEADER = ROOT / "native" / "include" / "paradesc" / "paradesc.h"


def files_in(folder, ending):
    """Files of a kind in a folder and below, but for what is made there."""
    made = {"out", "lib", "results-quick"}
    return [path for path in sorted(folder.rglob(f"*.{ending}")) if not made & set(path.relative_to(ROOT).parts)]


def pages():
    """Every Markdown file of the project."""
    return [*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in files_in(ROOT / folder, "md"))]


def without_code(text):
    """A page's text without what stands in fences and between backticks."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))


def links(path):
    """The targets of a page's links and pictures, without addresses on the web."""
    found = re.findall(r"\]\(([^)\s]+)\)", without_code(path.read_text(encoding="utf-8")))
    return [target for target in found if not re.match(r"[a-z]+:", target)]


def anchors(path):
    """The names of a page's headings, as the web shows them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    heads = re.findall(r"^#+ (.+)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def section(text, title):
    """The text below a heading, up to the next one of its kind or above."""
    found = re.search(rf"^(#+) {re.escape(title)}\n", text, re.M)
    assert found, f"{title} has no section"
    rest = text[found.end() :]
    end = re.search(rf"^#{{1,{len(found[1])}}} ", rest, re.M)
    return rest[: end.start()] if end else rest


def members(struct_name):
    """The members of a struct of the C interface."""
    body = re.search(rf"typedef struct {struct_name} {{(.*?)^}}", HEADER.read_text(), re.M | re.S)[1]
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.S)
    return [name for name in re.findall(r"(\w+);", body) if name != "struct_size"]


# ---- README and links


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= 600


def test_every_link_leads_to_a_file_and_to_a_heading_in_it():
    wrong = []
    for page in pages():
        for target in links(page):
            name, _, anchor = target.partition("#")
            file = (page.parent / name).resolve() if name else page
            if not file.exists() or (anchor and anchor not in anchors(file)):
                wrong.append(f"{page.relative_to(ROOT)}: {target}")
    assert wrong == []


def test_the_manual_leads_nowhere_outside_the_package():
    inside = (MANUAL, PICTURES, PICTURES / "descriptors")
    for page in (*MANUAL.glob("*.md"), CHANGES):
        for target in links(page):
            file = (page.parent / target.partition("#")[0]).resolve()
            assert file == CHANGES or file.parent in inside or target.startswith("#"), f"{page.name}: {target}"


def test_scripts_in_commands_exist():
    for page in pages():
        named = re.findall(r"(?:bash|python|-P) ((?:[\w-]+/)+[\w.-]+\.(?:sh|py))", page.read_text(encoding="utf-8"))
        for script in (name for name in named if name.split("/")[0] in FOLDERS):
            assert (ROOT / script).is_file(), f"{page.name}: {script}"


def test_files_in_the_developers_page_exist():
    folders = ("addon/paradesc", "addon/paradesc_blender", "addon/manual", "blend_samples", "native", "shaders", "tests")
    there = [f"/{path.relative_to(ROOT)}" for folder in folders for path in (ROOT / folder).rglob("*.*")]
    there += [f"/{path.name}" for path in ROOT.iterdir()] + [f"/addon/{path.name}/" for path in (ROOT / "addon").iterdir()]
    known = re.compile(r"[\w./-]*\w(?:/|\.(?:cpp|h|def|glsl|frag|comp|py|sh|cmake|md|txt|toml))|[a-z]+(?:/\w+)+")
    for word in sorted(set(re.findall(r"`([^`\n]+)`", (ROOT / "native" / "README.md").read_text(encoding="utf-8")))):
        if known.fullmatch(word) and not word.startswith(("/", "build")):
            assert any(f"/{word}" in path for path in there), word


# ---- Pictures


def test_every_picture_is_used_and_small():
    used = {(page.parent / target).resolve() for page in pages() for target in links(page)}
    for path in (path for folder in FOLDERS for ending in ENDINGS for path in files_in(ROOT / folder, ending)):
        assert path in used, f"{path.name} is on no page"
        packed = MANUAL in path.parents and path.suffix != ".gif"  # with the add-on; moving pictures may be larger
        assert path.stat().st_size < (400_000 if packed else 1_000_000), path.name
        if path.suffix == ".png":
            width, height = struct.unpack(">II", path.read_bytes()[16:24])
            assert min(width, height) > 100, path.name


def test_every_page_for_artists_begins_with_what_it_shows():
    listed = re.findall(
        r"\((\w+\.md)\)", (MANUAL / "README.md").read_text(encoding="utf-8").partition("[Artists, in depth]")[0]
    )
    assert len(listed) >= 9
    for name in listed:
        text = (MANUAL / name).read_text(encoding="utf-8")
        assert "](pictures/" in text, f"{name} has no picture"
        assert len(text.split()) < 900, f"{name} is long"


def test_every_picture_is_drawn_by_the_script():
    script = (PICTURES / "make.sh").read_text()
    for path in (path for ending in ENDINGS for path in PICTURES.glob(f"*.{ending}")):
        assert path.stem.removeprefix("color_") in script, path.name
    drawn = {path.stem for path in (PICTURES / "descriptors").glob("*.png")}
    assert drawn == {row.name for row in bridge.descriptors()}


# ---- The reference


def test_every_descriptor_has_a_section_with_picture_name_unit_formula_and_source():
    text = section(REFERENCE.read_text(encoding="utf-8"), "Descriptors")
    units = {-2: "1/length²", -1: "1/length", 0: "without unit", 2: "length²", 3: "length³"}
    for row in bridge.descriptors():
        about = section(text, row.label)
        assert f"(pictures/descriptors/{row.name}.png)" in about
        assert f"`{row.name}`" in about
        assert "- Formula: " in about
        assert "- Source: " in about
        if row.components == 1 and not row.map_degree:
            assert units[row.length_power] in about, row.name


def test_every_option_of_the_interface_is_in_the_reference():
    text = section(REFERENCE.read_text(encoding="utf-8"), "Settings")
    names = set(members("pdesc_options")) | {field.name for field in fields(bridge.Options)}
    assert [name for name in sorted(names) if f"`{name}`" not in text] == []


def test_every_count_of_the_reports_is_in_the_reference():
    text = section(REFERENCE.read_text(encoding="utf-8"), "The report")
    names = members("pdesc_mesh_report") + members("pdesc_field_report")
    assert len(names) > 30
    assert [name for name in names if f"`{name}`" not in text] == []


@IN_BLENDER
def test_every_setting_of_the_add_on_is_in_the_reference(registered):
    import bpy

    import paradesc_blender

    text = section(REFERENCE.read_text(encoding="utf-8"), "Settings")
    kept = (bpy.types.PropertyGroup, bpy.types.AddonPreferences)
    groups = [cls for module in paradesc_blender.modules() for cls in module.classes if issubclass(cls, kept)]
    groups.append(bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings"))
    names = [name for cls in groups for name in cls.__annotations__]
    assert len(names) > 60
    assert [name for name in names if f"`{name}`" not in text] == []


def test_every_option_of_the_command_line_is_in_the_reference():
    from paradesc.commands.main import make_parser

    text = REFERENCE.read_text(encoding="utf-8")
    (commands,) = (action.choices for action in make_parser()._actions if getattr(action, "choices", None))
    for name, parser in commands.items():
        assert f"`{name}`" in text
        for action in parser._actions:
            for option in action.option_strings:
                assert re.search(rf"`{option}\b", text), f"{name} {option}"


@IN_BLENDER
def test_every_preset_is_in_the_manual(registered):
    from paradesc_blender.settings import presets

    text = (MANUAL / "presets.md").read_text(encoding="utf-8")
    for name, preset in presets.PRESETS.items():
        assert f"| {preset.name} |" in text
        assert f"`{name}`" in REFERENCE.read_text(encoding="utf-8")


def test_changes_name_this_version():
    version = re.search(r"^project\(paradesc VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
    assert section(CHANGES.read_text(encoding="utf-8"), version).strip()


# ---- In the package


@pytest.fixture
def write_manual(monkeypatch):
    """The part of the packaging that makes the pages."""
    monkeypatch.syspath_prepend(str(ROOT / "native" / "cmake"))
    import manual

    return manual.write_manual


def test_every_link_of_the_web_pages_leads_to_a_file_and_to_a_heading_in_it(write_manual, tmp_path):
    pytest.importorskip("markdown", reason="makes the web pages")
    write_manual(tmp_path / "manual")
    found = sorted((tmp_path / "manual").glob("*.html"))
    pages_for_artists = {
        "start",
        "masks",
        "textures",
        "low_poly_edges",
        "wear",
        "high_to_low",
        "live",
        "colors",
        "sculpting",
        "export",
        "presets",
        "trouble",
        "artists",
    }
    assert {path.stem for path in found} == {
        "index",
        "reference",
        "pipelines",
        "python",
        "farms",
        "scans",
        "values",
        "changelog",
    } | pages_for_artists
    for page in found:
        text = page.read_text(encoding="utf-8")
        assert "<table>" in text or page.stem in {"changelog", "live", "sculpting", "high_to_low", "python"}
        for target in re.findall(r'(?:href|src)="([^"]+)"', text):
            name, _, anchor = target.partition("#")
            file = page.parent / name if name else page
            assert file.is_file(), f"{page.name}: {target}"
            assert not anchor or f'id="{anchor}"' in file.read_text(encoding="utf-8"), f"{page.name}: {target}"


def test_without_the_library_for_web_pages_the_pages_go_as_they_are(write_manual, monkeypatch, tmp_path):
    import manual

    monkeypatch.setattr(manual, "find_spec", lambda _name: None)
    write_manual(tmp_path / "manual")
    for page in (tmp_path / "manual").glob("*.md"):
        for target in links(page):
            assert (page.parent / target.partition("#")[0]).exists(), f"{page.name}: {target}"
    assert (tmp_path / "manual" / "README.md").is_file()


@IN_BLENDER
@pytest.mark.parametrize(("name", "operator"), [("index.html", "url_open"), ("README.md", "path_open"), ("", "")])
def test_the_question_mark_opens_the_manual_that_is_there(registered, monkeypatch, tmp_path, name, operator):
    import bpy

    from paradesc_blender.ui import manual

    opened = []
    calls = {
        "url_open": lambda url: opened.append(("url_open", url)),
        "path_open": lambda filepath: opened.append(("path_open", filepath)),
    }
    page = tmp_path / name
    if name:
        page.write_text("# The manual")
    monkeypatch.setattr(manual, "FIRST_PAGES", (tmp_path / "missing.html", page))
    assert bpy.ops.paradesc.manual.poll() == bool(name)
    if name:
        monkeypatch.setattr(bpy, "ops", SimpleNamespace(wm=SimpleNamespace(**calls)))
        manual.PARADESC_OT_manual.execute(None, bpy.context)
        assert opened == [(operator, page.as_uri() if operator == "url_open" else str(page))]


@IN_BLENDER
def test_a_source_tree_has_its_manual_too():
    from paradesc_blender.ui import manual

    assert manual.first_page().resolve() == MANUAL / "README.md"
