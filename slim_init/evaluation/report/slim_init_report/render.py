# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Markdown and HTML from the templates.

A report is one template (run.j2, suite.j2) that calls macros: heading, paragraph, items, code,
table, picture. They exist twice, in markdown.j2 and html.j2. In all texts `words between backticks`
are code; nothing else is markup."""
import base64
import os
import re

from jinja2 import Environment, FileSystemLoader, StrictUndefined

try:  # both moved to markupsafe
    from markupsafe import Markup, escape
except ImportError:
    from jinja2 import Markup, escape

# Characters in a line of a table: what fits a page of GitHub, and ours (see html.j2).
MARKDOWN_WIDTH = 105
HTML_WIDTH = 135


def _code_html(text):
    """`words` become <code>; a last backtick without a partner is itself."""
    return Markup(re.sub("`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def _cell_markdown(text):
    """"|" would end a cell and a line end the table."""
    return re.sub(r"[\r\n]+", " ", str(text)).replace("|", "\\|")


def _milliseconds(value, digits):
    """A time, or a dash where it does not exist."""
    return "-" if value is None or value != value else "%.*f" % (digits, value)


class _Page:
    """What the templates of one page share: headings for the list at the top, embedded pictures."""

    def __init__(self, folder):
        self.folder = folder
        self.headings = []

    def anchor(self, text):
        """Notes a heading and returns its anchor."""
        self.headings.append(("part-%d" % (len(self.headings) + 1), text))
        return self.headings[-1][0]

    def embed(self, file):
        """A picture as a data URI."""
        with open(os.path.join(self.folder, file), "rb") as picture:
            return "data:image/png;base64," + base64.b64encode(picture.read()).decode("ascii")


def _render(template, form, context, folder):
    environment = Environment(
        loader=FileSystemLoader(os.path.join(os.path.dirname(__file__), "templates")),
        autoescape=form == "html", undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page = _Page(folder)
    width = HTML_WIDTH if form == "html" else MARKDOWN_WIDTH
    environment.filters.update(code=_code_html, cell=_cell_markdown, ms=_milliseconds)
    environment.globals.update(anchor=page.anchor, embed=page.embed,
                               split=lambda table: table.split(width))
    body = environment.get_template(template).render(form=form + ".j2", **context)
    if form == "markdown":
        return re.sub(r"\n{3,}", "\n\n", "# %s\n\n%s" % (context["title"], body)).strip() + "\n"
    return environment.get_template("page.j2").render(title=context["title"], body=Markup(body),
                                                      headings=page.headings)


def write(template, context, folder):
    """Writes report.md and report.html into `folder`, where the pictures named in the context are.
    Returns the two files."""
    files = []
    for form, name in (("markdown", "report.md"), ("html", "report.html")):
        files.append(os.path.join(folder, name))
        with open(files[-1], "w", encoding="utf-8", errors="replace") as file:
            file.write(_render(template, form, context, folder))
    return files
