"""Pages from templates, with their style in them."""

from importlib.resources import files

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

_TEMPLATES = files("exudyn_crawler.views.report").joinpath("templates")


def rendered_page(template: str, **content: object) -> str:
    """Page of a template and what it shows; the style of all pages is in it."""
    environment = Environment(
        loader=FileSystemLoader(str(_TEMPLATES)),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    return environment.get_template(template).render(content, style=template_text("report.css"))


def template_text(name: str) -> Markup:
    """Text of a file beside the templates, to stand on a page as it is."""
    return Markup(_TEMPLATES.joinpath(name).read_text(encoding="utf-8"))
