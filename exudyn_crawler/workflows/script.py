"""How a script tells of what went wrong."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pydantic import ValidationError

from exudyn_crawler.errors import EquilibriumError, SimulationStopped

BAD_INPUT = 2
STOPPED = 3


@contextmanager
def readable_errors() -> Iterator[None]:
    """Turn the package's errors into one line and an exit code.

    Exits with 2 for bad input and 3 for a run that stopped early; other errors pass.
    """
    try:
        yield
    except SimulationStopped as stop:
        print(f"error: {stop}; what there is was kept", file=sys.stderr)
        raise SystemExit(STOPPED) from stop
    except EquilibriumError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(STOPPED) from error
    except ValidationError as error:
        for one in error.errors():
            place = ".".join(str(part) for part in one["loc"]) or error.title
            print(f"error: {place}: {one['msg']}, got {one['input']!r}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from error
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from error
