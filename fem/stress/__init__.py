"""Stress over long histories: recovery, extremes, hot spots, and verdicts on their accuracy.

The search for extremes: the entry is `extremes.recover_extremes`.
It returns the greatest and the least von Mises stress of each
node over time, and the highest stress over the nodes at each time. The result is that of a computation of
every stress at every time in double precision. Three steps for each segment of the history avoid most of
that work:

1. `candidates.find_candidates` computes all stresses in single precision. It uses the few directions along
   which the modal coordinates of a block of times move (a singular value decomposition). The stress of a
   node changes by no more than a known bound through dropped directions and rounding.
2. Times and nodes are grouped into cells of 32. A cell can hold the extreme only if its stress plus the
   bound reaches the best stress minus the bound. These cells are the candidates.
3. `extremes` recovers the candidates at full rank in double precision and returns the best of them. If more
   than a quarter of the cells are candidates, the whole segment is recovered at full rank instead.

Other results of a history, such as damage by cycles, are folds over blocks of stresses
(`folds.fold_stresses`), at full rank or at a reduced rank with a bound (`low_rank`).
"""

import lazy_loader

# `fem.trust` is a public name; it is imported at its first use
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"trust"})
