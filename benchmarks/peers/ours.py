"""This project, through its array floor."""

from attitude import propagate
from benchmarks.peers import Peer


def peers():
    return [Peer("attitude", "exact", propagate)]
