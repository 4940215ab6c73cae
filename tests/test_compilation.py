"""Compilation: what is kept on disk, what goes wrong there, and Ctrl-C meanwhile."""

import signal

import numba
import pytest
from numba.core import caching, event

from attitude.compilation import deferral, disk_cache
from attitude.compilation.disk_cache import kept_on_disk


def twice(x):
    return 2.0 * x


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def kept(folder, ending):
    return sorted(folder.rglob(f"*.{ending}"))


def test_kept_for_the_next_process(folder):
    assert kept_on_disk(twice, {})(1.5) == 3.0
    again = kept_on_disk(twice, {})
    assert again(1.5) == 3.0 and again.stats.cache_hits and not again.stats.cache_misses


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_a_torn_file_is_made_anew(folder, ending, left):
    """As a crash of the machine leaves it: empty, or the beginning alone."""
    kept_on_disk(twice, {})(1.5)
    (torn,) = kept(folder, ending)
    whole = torn.read_bytes()
    torn.write_bytes(whole[:left])
    assert kept_on_disk(twice, {})(1.5) == 3.0
    again = kept_on_disk(twice, {})
    assert again(1.5) == 3.0 and again.stats.cache_hits


def test_an_edit_of_the_package_invalidates_the_cache(folder, monkeypatch):
    kept_on_disk(twice, {})(1.5)
    monkeypatch.setattr(disk_cache, "_stamp", lambda: "another state of the sources")
    again = kept_on_disk(twice, {})
    assert again(1.5) == 3.0 and again.stats.cache_misses and not again.stats.cache_hits


def test_nothing_is_kept_that_could_be_out_of_date(folder, monkeypatch):
    """If numba renames the stamp of its index, edits elsewhere would not be noticed."""

    class Renamed(caching.IndexDataCacheFile):
        def __init__(self, *given, **named):
            super().__init__(*given, **named)
            del self._source_stamp

    monkeypatch.setattr(caching, "IndexDataCacheFile", Renamed)
    assert kept_on_disk(twice, {})(1.5) == 3.0
    assert not kept(folder, "nb?")


def test_a_full_disk_is_no_cache(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile._open_for_write", full)
    assert kept_on_disk(twice, {})(1.5) == 3.0
    assert not kept(folder, "nb?")


def test_an_interrupt_waits_for_the_end_of_the_outermost():
    deferral.hold_interrupts()
    deferral.hold_interrupts()
    signal.raise_signal(signal.SIGINT)
    deferral.release_interrupts()
    with pytest.raises(KeyboardInterrupt):
        deferral.release_interrupts()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    deferral.hold_interrupts()
    deferral.release_interrupts()


def test_a_handler_of_the_user_s_own_stays(monkeypatch):
    seen = []

    def note(number, frame):
        seen.append(number)

    before = signal.signal(signal.SIGINT, note)
    try:
        deferral.hold_interrupts()
        signal.raise_signal(signal.SIGINT)
        deferral.release_interrupts()
        assert seen == [signal.SIGINT] and signal.getsignal(signal.SIGINT) is note
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupted_compilation_can_be_had_again(folder):
    """Ctrl-C while numba is at work; the next call finds nothing half made."""

    class Press(event.Listener):
        def on_start(self, event):
            signal.raise_signal(signal.SIGINT)

        def on_end(self, event):
            pass

    function, press = kept_on_disk(twice, {}), Press()
    event.register("numba:compile", press)
    try:
        with pytest.raises(KeyboardInterrupt):
            function(1.5)
    finally:
        event.unregister("numba:compile", press)
    assert function(1.5) == 3.0
