"""Interrupts that a callback swallows are remembered."""

import os
import signal
import weakref

import pytest

from fem.interrupts import interrupts_remembered, interrupts_wait


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_within_a_callback_is_remembered(number):
    before = signal.signal(number, signal.default_int_handler)
    try:
        with interrupts_remembered() as ask:
            ask()
            one = set()
            reference = weakref.ref(one, lambda _gone: os.kill(os.getpid(), number))
            del one  # the interrupt is raised in the callback, where Python drops it
            assert reference() is None
            with pytest.raises(KeyboardInterrupt):
                ask()
        assert signal.getsignal(number) is signal.default_int_handler
    finally:
        signal.signal(number, before)


@pytest.mark.usefixtures("interruptible")
def test_delayed_interrupts_are_remembered_too():
    with interrupts_remembered() as ask:
        with pytest.raises(KeyboardInterrupt), interrupts_wait():
            os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            ask()
