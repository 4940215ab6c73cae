"""Tables of averaged torques are kept on the disk while the tests of this folder run."""

import pytest


@pytest.fixture(autouse=True, scope="package")
def _kept_tables(tmp_path_factory):
    """Many tests ask for the same tables; those of other folders compute theirs each time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ATTITUDE_CACHE", str(tmp_path_factory.mktemp("tables")))
        yield
