"""Log of a run in its folder."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LOG = "run.log"

logger = logging.getLogger("exudyn_crawler")


class _LogFile(logging.FileHandler):
    """Log that does not stop a run where it cannot be written."""

    def handleError(self, _record: logging.LogRecord) -> None:  # noqa: N802
        pass

    def close(self) -> None:
        with suppress(OSError):
            super().close()


@contextmanager
def logged(out: Path, anew: bool) -> Iterator[None]:
    """Send the package's log into a folder; an earlier log is continued unless it is to begin `anew`."""
    handler = _LogFile(out / LOG, mode="w" if anew else "a", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        handler.close()
