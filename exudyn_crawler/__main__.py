"""``python -m exudyn_crawler`` is the command `exudyn-crawler`."""

import sys

from exudyn_crawler.errors import ENDED_FROM_OUTSIDE, GOES_ON, INTERRUPTED


def main() -> None:
    """Entry point of `exudyn-crawler`; an interrupt while it loads is told in a line as any later one."""
    try:
        from exudyn_crawler.cli import app, call

        call(app)
    except KeyboardInterrupt:
        print(f"error: {INTERRUPTED}; {GOES_ON}", file=sys.stderr)
        sys.exit(ENDED_FROM_OUTSIDE)


if __name__ == "__main__":
    main()
