"""The catalogs: each language has every text that users see, and no other, and Blender looks them up in our context."""

import re

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import texts  # noqa: E402

from paradesc_blender.settings import translation  # noqa: E402
from paradesc_blender.ui import drawing  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

LANGUAGES = pytest.mark.parametrize("language", sorted(translation.LANGUAGES))
# The writing of a language that has one of its own, and the texts that stand in Latin letters there too.
WRITING = {"ja": "[\u3040-\u30ff\u4e00-\u9fff]", "zh": "[\u4e00-\u9fff]"}
LATIN = {"Viridis", "OpenEXR", "Harris k", "Alpha"}
# The panel's own sentences have to fit: what a translation may be longer, of texts above a few words.
LONGER, SHORT = 2.0, 12
INTERNATIONAL = pytest.mark.skipif(
    not bpy.app.build_options.international, reason="this Blender was built without languages"
)


@pytest.fixture
def in_language():
    """Switches the interface to a language, by any of the names that Blender has had for it; English at the end."""
    view = bpy.context.preferences.view

    def switch(*names):
        view.language = next(name for name in names if name in bpy.app.translations.locales)
        view.use_translate_interface = view.use_translate_tooltips = True
        if hasattr(view, "use_translate_reports"):
            view.use_translate_reports = True

    yield switch
    view.language = "en_US"


@LANGUAGES
def test_every_text_is_translated(language):
    known = translation.catalog(language)
    assert [f"{text!r} in {where}" for text, where in texts.collected().items() if text not in known] == []


@LANGUAGES
def test_no_translation_is_left_of_a_text_that_is_gone(language):
    assert sorted(translation.catalog(language).keys() - texts.collected().keys()) == []


@LANGUAGES
def test_translations_have_the_places_of_their_texts(language):
    catalog = translation.catalog(language)
    assert len(catalog) > 400
    places = {text: (sorted(texts.PLACE.findall(text)), sorted(texts.PLACE.findall(catalog[text]))) for text in catalog}
    assert [text for text, (wanted, given) in places.items() if wanted != given] == []


@LANGUAGES
def test_translations_are_in_the_language_and_end_as_their_texts_do(language):
    for text, translated in translation.catalog(language).items():
        assert translated and translated.strip() == translated or text != text.strip(), text
        assert len(translated) < LONGER * len(text) + SHORT, text
        assert (text[-1] in ".…:") == (translated[-1] in ".。．…:："), text
        if language in WRITING and text not in LATIN and re.search("[A-Za-z]{2}", texts.PLACE.sub("", text)):
            assert re.search(WRITING[language], translated), text


def test_blender_looks_labels_up_in_our_context():
    for cls in texts.classes():
        if hasattr(cls, "bl_label"):
            assert texts.rna_of(cls).translation_context == translation.CONTEXT, cls
    if translation.HAS_CONTEXT:
        contexts = {field.translation_context for _, _, field in texts.fields()}
        assert contexts == {translation.CONTEXT}


def test_sentences_with_names_in_them_are_found_by_what_stands_around():
    sentence = 'The mesh "The mesh "Cube"" is linked from another file; make it local first.'
    template = 'The mesh "{0}" is linked from another file; make it local first.'
    assert translation.matched(sentence) == (template, ('The mesh "Cube"',))
    shown = translation.translated(sentence, lambda text, _context: text.replace("The mesh", "Das"))
    assert shown.startswith('Das "The mesh "Cube""')
    assert translation.matched("The mesh is linked from another file; make it local first.") is None
    assert translation.matched(template) is None


def test_sentences_within_sentences_are_translated_and_names_in_quotes_are_not():
    marked = {"Change of {0}": "<{0}>", "Cavity": "C", 'Normals are those of "{0}".': '"{0}"!'}

    def look(text, _context):
        return marked.get(text, text)

    assert translation.translated("Change of Cavity", look) == "<C>"
    assert translation.translated('Normals are those of "Cavity".', look) == '"Cavity"!'


def test_catalogs_that_are_missing_or_broken_leave_english(monkeypatch, tmp_path):
    monkeypatch.setattr(translation, "FOLDER", tmp_path)
    (tmp_path / "de.json").write_text("{", encoding="utf-8")
    assert [translation.catalog(name) for name in translation.LANGUAGES] == [{}, {}, {}]
    translation.unregister()
    translation.register()
    assert translation.label("Cavity") == "Cavity"


def test_lines_break_between_signs_where_a_language_has_no_spaces():
    assert drawing.wrapped("two words", 5) == ["two", "words"]
    assert drawing.wrapped("先にメッシュ，を選択", 5) == ["先にメッシ", "ュ，を選択"]
    assert drawing.wrapped("先にメッ，を選択 Cube", 4) == ["先にメ", "ッ，を選", "択", "Cube"]  # no comma begins a line


@INTERNATIONAL
@pytest.mark.parametrize(
    ("names", "cavity", "select"),
    [
        (("de_DE", "de"), "Hohlraum", "Zuerst ein Maschenobjekt auswählen"),
        (("ja_JP", "ja"), "キャビティ", "先にメッシュオブジェクトを選択してください"),
        (("zh_HANS", "zh_CN"), "腔体", "请先选择网格物体"),
        (("fr_FR", "fr"), "Cavity", "Select a mesh object first"),
        (("en_US",), "Cavity", "Select a mesh object first"),
    ],
)
def test_each_language_has_its_words_and_those_that_we_lack_have_none_of_blenders(in_language, names, cavity, select):
    in_language(*names)
    assert translation.label("Cavity") == cavity
    for look in (translation.label, translation.said, translation.tooltip):
        assert look("Select a mesh object first") == select
    sentence = translation.said('The mesh "Cube" has no faces; there is no surface to measure.')
    assert "Cube" in sentence
    assert sentence.startswith("The mesh") == (cavity == "Cavity")


@INTERNATIONAL
def test_the_languages_are_gone_with_the_add_on(in_language):
    in_language("de_DE", "de")
    assert translation.label("Edge Wear") == "Abrieb"
    translation.unregister()
    assert translation.label("Edge Wear") == "Edge Wear"
    translation.register()
