"""Sphinx: markdown by MyST, the pydata theme, the library by autodoc. `make docs` builds it; the network is not asked.

No sphinx-gallery: the three scripts of docs/examples are shown as they are and run in the tests, not at each build.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))  # this checkout is documented, whatever is installed

project = "synth"
author = "the synth developers"
copyright = author
release = re.search(r'__version__ = "(.+)"', (ROOT / "synth" / "__init__.py").read_text(encoding="utf-8"))[1]
version = release

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["examples"]  # scripts, shown by library.md
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True  # `stage=silent`, not the function's address
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
napoleon_google_docstring = False  # NumPy style throughout

highlight_language = "none"  # formulas and answers; code says its language
html_theme = "pydata_sphinx_theme"
html_title = f"synth {release}"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sourcelink = False
html_copy_source = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {"text": "synth"},
    "show_prev_next": True,
    "show_toc_level": 2,
    "header_links_before_dropdown": 6,
    "navbar_end": ["theme-switcher"],
    "footer_start": [],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
