"""This project, by its array function `propagate`."""

from attitude import propagate
from benchmarks.peers import Peer


def peers():
    return [Peer("attitude", "exact", propagate)]
