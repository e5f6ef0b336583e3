"""Gears, which move a track and carry the machine, a file for each kind.

- dragged: the drive moves the front shoe, and loads press on the shoes;
- rolled: a side frame rolls over shoes that lie before it;
- closed: a track goes round tumbler, idler and rollers of its side frame;
- machine: two closed tracks and the car body between them.
"""

from typing import Annotated

from pydantic import Field

from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.gear.rolled import Rolled

AnyGear = Annotated[Dragged | Rolled | Closed | Machine, Field(discriminator="kind")]
"""Gear of a case."""
