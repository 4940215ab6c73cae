"""Tables of averaged torques are kept on the disk for all tests here: many ask for the same ones.

A table that is read is the one that was computed, bit for bit, so that both are tested.
"""

import pytest


@pytest.fixture(autouse=True, scope="session")
def _kept_tables(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ATTITUDE_CACHE", str(tmp_path_factory.mktemp("tables")))
        yield
