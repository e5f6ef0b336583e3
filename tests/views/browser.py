"""A reader of pages in a browser: a Chromium found on the machine, driven without a display."""

import shutil

import numpy as np

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def in_plot(what, plot):
    """Script that gives the value of an expression of a plot's data and layout."""
    parts = f"const {{ data, _fullData: full, layout }} = document.querySelector('{plot}');"
    return f"() => {{ {parts} return {what}; }}"


class Reader:
    """A reader of the page: what went wrong, what was asked for, and what the plots show.

    `screen` are options of the browser's page: its size, whether it is touched.
    """

    def __init__(self, browser, path, ready="body[data-ready=yes]", **screen):
        self.page = browser.new_page(**{"viewport": {"width": 1300, "height": 900}} | screen)
        self.address, self.errors, self.requests = path.as_uri(), [], []
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type == "error" else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.route("**/*", self.decide)
        self.page.goto(self.address)
        self.page.wait_for_selector(ready)

    def decide(self, route):
        """Note a request, and let that of the page itself through alone."""
        self.requests.append(route.request.url)
        if route.request.url == self.address:
            route.continue_()
        else:
            route.abort()

    def shown(self, what, plot="#plot-0 .figure"):
        """Value of an expression of the plot's data and layout."""
        return self.page.evaluate(in_plot(what, plot))

    def wait(self, what, plot="#plot-0 .figure"):
        """Wait until an expression of the plot's data and layout holds."""
        self.page.wait_for_function(in_plot(what, plot))

    def drawn(self, plot, number=0):
        """Colours of a body that is drawn; what is not known has none."""
        colours = f"Array.from(data[{number}].intensity, (one) => Number.isNaN(one) ? null : one)"
        return np.array(self.shown(colours, plot), dtype=float)

    def places(self, plot, number):
        """Corners (n, 3) of a body that is drawn."""
        return np.transpose(self.shown(f"['x', 'y', 'z'].map((a) => Array.from(data[{number}][a]))", plot))
