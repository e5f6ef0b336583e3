"""The engine: the only import of Exudyn.

This is its build with range checks. The one without saves 5 % of a run's time, but its last digits depend on
the processor's instruction set.
"""

import exudyn as exu
import exudyn.itemInterface as items

exu.config.printToConsole = False

__all__ = ["exu", "items"]
