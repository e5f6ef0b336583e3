"""Case files of texts: read, or refused."""

import pytest

from exudyn_crawler import read_case
from exudyn_crawler.errors import CaseFileError


@pytest.fixture
def read(tmp_path):
    """Case file of a text, with changes."""

    def read(text, changes=()):
        path = tmp_path / "case.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_case(path, changes)

    return read


@pytest.fixture
def refused(read, tmp_path):
    """Faults that a text is refused for, without the file's name."""

    def refused(text, changes=()):
        with pytest.raises(CaseFileError) as caught:
            read(text, changes)
        lines = str(caught.value).splitlines()
        assert lines == [f"{tmp_path / 'case.toml'}: {fault}" for fault in caught.value.errors]
        return caught.value.errors

    return refused
