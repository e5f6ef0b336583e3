"""The engine, as every builder and run here takes it.

Exudyn's build without range checks is not asked for: it gains 5 % of a run's time and makes the last digits
hang on the processor's instruction set.
"""

import exudyn as exu
import exudyn.itemInterface as items

exu.config.printToConsole = False

__all__ = ["exu", "items"]
