"""The documentation site: ``make docs``."""

import re
import shutil
import subprocess
from importlib.metadata import version as installed
from pathlib import Path

from pygments.lexers import CppLexer
from sphinx.highlighting import lexers

import stillreach as sr

project = "stillreach"
author = "the stillreach authors"
version = release = installed("stillreach")
project_copyright = author

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
DOXYGEN = shutil.which("doxygen")
"""Reads the comments of the C++ front door; without it that page is a note."""
if DOXYGEN:
    extensions.append("breathe")
breathe_default_project = "stillreach"
myst_heading_anchors = 4
exclude_patterns = ["images/make.py"]
suppress_warnings = ["ref.python"]  # several classes have an n
lexers["cc"] = CppLexer()

autodoc_typehints = "signature"
autodoc_type_aliases = {"npt.ArrayLike": "ArrayLike", "FloatArray": "FloatArray"}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "stillreach"
html_show_search_summary = False  # search works from a disk, too
html_show_sphinx = False
html_copy_source = False


ROOT = Path(__file__).parents[1]
LIVE = """
```{raw} html
<iframe src="live.html" title="A Panda that you can break" style="width: 100%; height: 40rem; border: 0"></iframe>
<p>Click a joint to break it. <a href="live.html">The page alone</a>, <a href="view.html">how to make one</a>.</p>
```
"""
"""The arm on the front page."""
ELSEWHERE = {r"\]\((?:\.\./)?examples/\w+\.py\)": "](examples.md)", r"\]\(\.\./ARCHITECTURE\.md": "](architecture.md"}
"""Links to files outside the site, and the pages that show them."""


def setup(app):
    """What the pages say to readers of the repository becomes what readers of the site need."""
    if DOXYGEN:
        _read_headers(app)
    app.connect("autodoc-process-docstring", _bars_as_they_are)
    app.connect("source-read", _for_the_site)
    app.connect("env-updated", _modules_with_source)
    app.connect("build-finished", _live_page)


def _read_headers(app):
    """Doxygen's XML of the front door, for Breathe."""
    folder = Path(app.doctreedir).parent / "doxygen"
    folder.mkdir(parents=True, exist_ok=True)
    headers = [f'"{ROOT / "include" / "stillreach" / name}"' for name in ("stillreach.hpp", "memory.hpp", "urdf.hpp")]
    settings = {
        "INPUT": " ".join(headers),
        "OUTPUT_DIRECTORY": f'"{folder}"',
        "GENERATE_XML": "YES",
        "GENERATE_HTML": "NO",
        "GENERATE_LATEX": "NO",
        "QUIET": "YES",
        "WARN_IF_UNDOCUMENTED": "NO",
        "EXTRACT_ALL": "YES",
        "MACRO_EXPANSION": "YES",
        "EXPAND_ONLY_PREDEF": "YES",
        "PREDEFINED": '"STILLREACH_BEGIN=namespace stillreach {" STILLREACH_END=}',
    }
    text = "".join(f"{name} = {value}\n" for name, value in settings.items())
    subprocess.run([DOXYGEN, "-"], input=text, text=True, check=True)
    app.config.breathe_projects = {"stillreach": str(folder / "xml")}


def _bars_as_they_are(app, what, name, thing, options, lines):
    """Bars in docstrings are absolute values, not substitutions."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def _modules_with_source(app, env):
    """The list of module sources links those that have a page: not the compiled one, which viewcode notes as False."""
    modules = getattr(env, "_viewcode_modules", {})
    for name in [name for name, source in modules.items() if not source]:
        del modules[name]


def _for_the_site(app, page, source):
    """The first steps are the README's; links to other files lead to their pages."""
    text = source[0]
    if page == "index":
        text = text.replace("\n![", LIVE + "\n![", 1)
    if page == "reference-cpp" and not DOXYGEN:
        text = text.partition("```")[0] + "This page was built without doxygen: read the comments in the headers.\n"
    if page == "start":
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        first, last = readme.index("## Install"), readme.index("## Which joint can an arm not lose?")
        text += readme[first:last].replace("](docs/", "](")
    for pattern, there in ELSEWHERE.items():
        text = re.sub(pattern, there, text)
    source[0] = text


def _live_page(app, error):
    """The page that the front page shows, beside it."""
    if error is None and app.builder.format == "html":
        sr.arms.panda().page().save(Path(app.outdir) / "live.html")
