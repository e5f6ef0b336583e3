"""``python -m studies NAME`` runs a study."""

from exudyn_crawler.cli import call
from studies.commands import app

if __name__ == "__main__":
    call(app)
