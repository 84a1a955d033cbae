"""Every relative link and anchor of the built site leads somewhere."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from tests.docs.pages import ROOT

SITE = ROOT / "build" / "docs"
GOOD = '<p id="here">a <a href="b.html#part">b</a> <a href="#here">here</a> <a href="https://example.org">far</a></p>'
OTHER = (
    '<h1 id="part">b</h1> <img src="pictures/one%20two.png"> <a href="mailto:a@example.org">a</a> <a href=".">up</a>'
)


@pytest.fixture(scope="module")
def checker():
    """The module `scripts/check_links.py`."""
    spec = spec_from_file_location("check_links", ROOT / "scripts" / "check_links.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A site of two pages and a picture, whole."""
    folder = tmp_path / "site"
    (folder / "pictures").mkdir(parents=True)
    (folder / "pictures" / "one two.png").touch()
    (folder / "index.html").write_text(GOOD)
    (folder / "b.html").write_text(OTHER)
    return folder


def test_links_of_the_built_site_lead_somewhere(checker) -> None:
    if not (SITE / "index.html").exists():
        pytest.skip("the site is not built: make docs")
    assert checker.broken_links(SITE) == []


def test_a_whole_site_has_no_broken_link(checker, site: Path, capsys) -> None:
    assert checker.main(str(site)) == 0
    assert capsys.readouterr().out == "2 pages, 0 broken links\n"


@pytest.mark.parametrize(
    ("spoiled", "report"),
    [
        ('<a href="c.html">', "index.html:1: c.html: no such file"),
        ('\n<a href="b.html#gone">', "index.html:2: b.html#gone: no such anchor"),
        ('<a href="#gone">', "index.html:1: #gone: no such anchor"),
        ('<img src="pictures/three.png">', "index.html:1: pictures/three.png: no such file"),
        ('<a href="../README.md">', "index.html:1: ../README.md leads out of the site"),
    ],
)
def test_a_broken_link_is_reported(checker, site: Path, spoiled: str, report: str, capsys) -> None:
    (site / "index.html").write_text(spoiled)
    assert checker.main(str(site)) == 1
    assert capsys.readouterr().out.splitlines() == [report, "2 pages, 1 broken links"]


def test_a_folder_without_a_site_is_an_error(checker, tmp_path: Path) -> None:
    assert checker.main(str(tmp_path)) == 1
