"""Digests of source files: results of changed sources count as other results."""

import hashlib
from pathlib import Path

FEM = Path(__file__).parent
"""Folder of this package's sources."""


def source_digest(*sources: Path) -> str:
    """Return the SHA-256 of Python sources: files, or all files of a folder."""
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(path.read_bytes())
    return digest.hexdigest()
