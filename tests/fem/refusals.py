"""Calls that are refused."""

from collections.abc import Callable

import pytest


def refused(told: str, call: Callable, *arguments, error: type[Exception] = ValueError, **options) -> None:
    """Assert that a call ends with an error whose text matches what is told."""
    with pytest.raises(error, match=told):
        call(*arguments, **options)
