"""The site of the manual and the interfaces is built without a warning, and shows everything that is public."""

import re
import subprocess
import sys
from importlib.util import find_spec

import pytest

from sources import ROOT

SITE = ROOT / "addon" / "site"
GENERATOR = ("sphinx", "myst_nb", "numpydoc", "furo")


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    """The folder of the site; links that lead nowhere are warnings, which are errors here."""
    if missing := [name for name in GENERATOR if find_spec(name) is None]:
        pytest.skip(f"{', '.join(missing)} not installed; addon/site/requirements.txt names what builds the site")
    folder = tmp_path_factory.mktemp("site")
    words = ["-E", "-W", "--keep-going", "-q", "-c", SITE, ROOT / "addon", folder]
    done = subprocess.run([sys.executable, "-m", "sphinx", *words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def test_the_site_has_every_page_and_needs_no_network(html):
    sources = [*(ROOT / "addon" / "manual").glob("*.md"), *(ROOT / "addon" / "notebooks").glob("*.ipynb")]
    for source in sources:
        assert (html / source.parent.name / f"{source.stem}.html").is_file(), source.name
    for page in html.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert re.findall(r'<(?:script|img|link rel="stylesheet")[^>]* (?:src|href)="(https?:[^"]*)"', text) == []


def test_the_api_page_shows_everything_that_is_public(html):
    package = (ROOT / "addon" / "paradesc" / "__init__.py").read_text(encoding="utf-8")
    names = re.search(r"__all__ = \[(.*?)\]", package, re.S)[1]
    page = (html / "site" / "api.html").read_text(encoding="utf-8")
    for name in re.findall(r'"(\w+)"', names):
        assert f'id="paradesc.{name}"' in page, name
