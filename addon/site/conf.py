"""Sphinx's settings of the site: the manual, the notebooks and the interfaces of Python and C; build.sh builds it."""

import sys
from pathlib import Path
from types import SimpleNamespace

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
# The accessor's page needs its class, and nothing of PyVista.
sys.modules["pyvista"] = SimpleNamespace(PolyData=object, register_dataset_accessor=lambda *_: lambda cls: cls)

import paradesc  # noqa: E402 (found by the path above)

project = "Paradesc"
author = copyright = "The Paradesc authors"  # noqa: A001 (Sphinx's name)
release = paradesc.__version__
extensions = ["sphinx.ext.autodoc", "numpydoc", "myst_nb"]
include_patterns = ["*.md", "manual/*.md", "notebooks/*.md", "notebooks/*.ipynb", "site/*.md"]
exclude_patterns = ["PACKAGE.md"]

# Links to headings are those of GitHub, and notebooks are shown as they are stored.
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
nb_execution_mode = "off"

autodoc_typehints = "none"  # the parameters say their types
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 88
numpydoc_show_class_members = False

html_theme = "furo"
html_title = f"Paradesc {release}"
html_static_path = ["style.css"]
html_css_files = ["style.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
html_copy_source = False


def write_mathml(translator: object, node: nodes.Element) -> None:
    """Writes a formula as MathML, which browsers draw by themselves, without a network."""
    translator.body.append(tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block)))
    raise nodes.SkipNode


def setup(app: object) -> None:
    """Makes MathML one of Sphinx's choices."""
    app.add_html_math_renderer("mathml", (write_mathml, None), (write_mathml, None))
