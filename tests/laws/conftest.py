"""What several laws are tried on."""

import pytest

from tests.loop import two_rows


@pytest.fixture(scope="session")
def mission():
    """Two short rows."""
    return two_rows()
