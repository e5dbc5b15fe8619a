# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the documents, and the engine's docstrings, as a site: `make docs`, in build/docs. It opens from disk, too."""

import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

CHECKOUT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(CHECKOUT))  # the engine is imported without Blender

project = "PRT Relight"
copyright = "PRT Relight developers, GPL-3.0-or-later"
html_title = project
html_theme = "furo"
html_show_sphinx = False
html_extra_path = ["examples"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.apidoc"]
exclude_patterns = ["examples"]

myst_enable_extensions = ["html_image"]
myst_heading_anchors = 4  # as far down as documents link

napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_attr_annotations = False  # the signature has them
autodoc_typehints = "signature"
python_use_unqualified_type_names = True
add_module_names = False
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
apidoc_modules = [
    {
        "path": str(CHECKOUT / "prt_addon"),
        "destination": "engine",
        "exclude_patterns": [
            str(CHECKOUT / "prt_addon" / other)
            for other in ("scene", "worker", "glances.py", "handlers.py", "session.py")
        ],
        "separate_modules": True,
        "module_first": True,
    }
]


def setup(app: Sphinx) -> None:
    """README.md and its like are included from one folder up."""
    app.connect("include-read", seen_from_here)
    app.connect("doctree-read", open_examples)
    app.connect("autodoc-process-docstring", whole_sentences, priority=400)  # before Napoleon's, at 500


def seen_from_here(_app: Sphinx, _path: Path, _parent: str, content: list[str]) -> None:
    """Turn the links of an included page into what they are in this folder."""
    content[0] = re.sub(r"""(\]\(|src=")docs/""", r"\1", content[0])


def open_examples(_app: Sphinx, doctree: nodes.document) -> None:
    """Link to the pages of examples beside their scripts, which `html_extra_path` copies: a download is without them."""
    for link in list(doctree.findall(addnodes.download_reference)):
        if link["reftarget"].startswith("examples/"):
            path = link["reftarget"].removeprefix("examples/")
            link.replace_self(nodes.reference("", "", *link.children, refuri=path, internal=True))


def whole_sentences(_app: Sphinx, kind: str, _name: str, _of: object, _options: object, lines: list[str]) -> None:
    """Keep Napoleon from taking what stands before a property's first colon for its type."""
    if kind in ("property", "attribute", "data"):
        lines.insert(0, "")
