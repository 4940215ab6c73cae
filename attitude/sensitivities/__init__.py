"""How attitudes depend on the initial state and the inertia: derivatives, errors, samples.

``columns``
    Derivatives of attitudes and angular velocities of many bodies, as arrays.
``covariance``
    Covariances of states, and what follows from them at other epochs.
``elements``
    The normal form of a motion, and the state that has given elements.
"""
