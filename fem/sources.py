"""Digests of sources: results of other sources are other results."""

import hashlib
from pathlib import Path

FEM = Path(__file__).parent
"""Sources of this package."""


def source_digest(*sources: Path) -> str:
    """SHA-256 of some Python sources: files, or all in a folder."""
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(path.read_bytes())
    return digest.hexdigest()
