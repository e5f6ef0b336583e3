"""All benchmarks; `benchmarks/README.md` has their output on a named machine.

`python -m benchmarks.run FOLDER` also writes growth.csv and growth.png for docs/speed.md.
"""

import sys
from pathlib import Path

from benchmarks import cells, closed, fem, growth, rigid, static_fields, stress

if __name__ == "__main__":
    growth.main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    cells.main()
    closed.main()
    rigid.main()
    fem.main()
    static_fields.main()
    stress.main()
