"""Settings of Sphinx: ``make docs`` writes the pages and the reference to build/docs."""

from soft_sim_ros import __version__

project = "soft_sim_ros"
author = copyright = "soft_sim_ros developers"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
root_doc = "index"
myst_heading_anchors = 4
napoleon_google_docstring = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
html_theme = "alabaster"
html_theme_options = {"page_width": "72rem", "description": "Soft manipulators in ROS 2"}
html_copy_source = False
