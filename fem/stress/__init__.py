"""Stress over long histories: recovery, extremes, hot spots, and how far to trust them.

How the search for extremes works
---------------------------------
The entry is `extremes.recover_extremes`. It returns the greatest and the least von Mises stress of each
node over time, and the highest stress over the nodes at each time, as if the stress of every node had been
computed at every time in double precision. Most of that work is avoided in three steps for each segment of
the history:

1. `candidates.find_candidates` computes all stresses in single precision along the few directions that the
   modal coordinates of a block of times move in (a singular value decomposition). The directions that it
   drops, and rounding, change the stress of a node by no more than a bound that is known.
2. Times are grouped into cells of 32, and so are nodes. A cell can hold the extreme only if its stress plus
   the bound reaches the best stress minus the bound. The cells that can are the candidates.
3. `extremes` recovers the candidates at full rank in double precision and returns the best of them. Where
   the bounds leave more than a quarter of the cells, the whole segment is recovered at full rank instead.

Other results of a history, such as damage by cycles, are folds over blocks of stresses
(`folds.fold_stresses`), at full rank or at a reduced rank with a bound (`low_rank`).
"""

import lazy_loader

# `fem.trust` is a public name; it is imported when it is asked for
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"trust"})
