"""The contract of motions: attitudes at any TDB epoch of a span.

Free rotations, chains of arcs, torqued motions, tables and C-kernels are motions; events, scenes,
files and the command line use no other members than those of `Motion`.
"""

from __future__ import annotations

from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from attitude._support import markup, synonyms, validation
from attitude._support.arrays import Valued, copied, frozen
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.motions._history import AttitudeHistory

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Protocol

    from numpy.typing import ArrayLike

    from attitude._solver.regime import Regime
    from attitude._support.annotations import (
        EpochOrSeconds,
        Epochs,
        FilePath,
        FloatArray,
    )
    from attitude.motions._body import Body
    from attitude.motions._published import Published
    from attitude.motions._spin import Spin

    class HasAttitudes(Protocol):
        """A motion, or any other object with ``.at(t)``; see `motion_of`."""

        def at(self, t: Any, /) -> AttitudeHistory:
            """The attitudes at some epochs."""


_NO_JOINTS = frozen(np.zeros(0))


class RateBounds(NamedTuple):
    """Upper bounds, rad/s^k or inf, of the size of the k-th derivative of R a, for any unit a."""

    first: float
    second: float
    third: float


class Motion(Valued):
    """Base of all motions; it implements what follows from attitudes at epochs.

    A new kind of motion defines

    ``epoch``
        Instant from which its seconds count.
    ``_evaluate(seconds, low, order)``
        Attitudes (..., 4) body to ICRF, for an order of 1 or more angular velocities (..., 3) in
        rad/s over the body axes, for 2 angular accelerations (..., 3) in rad/s2, as a list, at
        TDB seconds + low since the epoch (float64 arrays of any shape; low may be None).  The list
        may be longer than `order` requires.  NaN for NaN; an AttitudeError outside of its span.

    and, if the defaults of the base do not hold,

    ``span``
        First and last Instant of its attitudes, or None: any epoch.
    ``joints``
        (N,) TDB seconds since the epoch, ascending, at which the angular velocity jumps.  The state
        there is that after the jump.  Writers of files start a new segment there.
    ``breaks()``
        The joints in two doubles, if one is not exact.
    ``body``; ``body_at(t)``, ``constant_body(what)``, ``momentum_in_body(history)``
        The Body at the epoch, None if the inertia is unknown; the methods if it changes.
    ``momentum``
        (3,) angular momentum in ICRF, kg m2/s, if it is constant, else None.
    ``smooth``
        Whether angular accelerations are known and continuous between joints.
    ``rate_bounds(seconds)``
        `RateBounds` that hold from there to the next joint, or None if they are unknown.
    ``turning_rate_at(seconds, low, *, wxyz, angular_velocity)``
        The rate at which attitudes turn, if it is not the angular velocity.
    ``has_rates_at(seconds, low)``
        Whether angular velocities there are more exact than differences of attitudes.
    ``_value``
        Names of the attributes that two equal motions share; without them a motion equals itself
        alone.
    ``meta``
        Names and comments of the file from which the motion was read.
    ``close()``
        Release its resources; motions are context managers.

    >>> import numpy as np
    >>> from attitude import epochs
    >>> class Swing(Motion):                # 0.1 rad about z to either side, at 1 Hz
    ...     epoch = epochs.instant("2026-01-01")
    ...     def _evaluate(self, seconds, low, order):
    ...         w = 2.0 * np.pi
    ...         angle, zero = 0.05 * np.sin(w * seconds), 0.0 * seconds
    ...         wxyz = np.stack([np.cos(angle), zero, zero, np.sin(angle)], axis=-1)
    ...         rate = np.stack([zero, zero, 0.1 * w * np.cos(w * seconds)], axis=-1)
    ...         bend = np.stack([zero, zero, -0.1 * w**2 * np.sin(w * seconds)], axis=-1)
    ...         return [wxyz, rate, bend]
    >>> Swing().at([0.0, 0.25]).angular_velocity.round(6) + 0.0
    array([[0.      , 0.      , 0.628319],
           [0.      , 0.      , 0.      ]])
    """

    if TYPE_CHECKING:
        # Read-only for type checkers, so that a subclass may define attributes or properties.
        @property
        def epoch(self) -> _instants.Instant:
            """Instant from which the seconds count."""

        @property
        def span(self) -> tuple[_instants.Instant, _instants.Instant] | None:
            """First and last Instant of the attitudes, or None: any epoch."""

        @property
        def joints(self) -> FloatArray:
            """(N,) TDB seconds since the epoch at which the angular velocity jumps."""

        @property
        def body(self) -> Body | None:
            """The Body at the epoch, None if the inertia is unknown."""

        @property
        def momentum(self) -> FloatArray | None:
            """(3,) angular momentum in ICRF, kg m2/s, if it is constant, else None."""

        @property
        def smooth(self) -> bool:
            """Whether angular accelerations are known and continuous between joints."""

        @property
        def meta(self) -> Mapping[str, Any]:
            """Names and comments of the file from which the motion was read."""
    else:
        span = None
        joints = _NO_JOINTS
        body = None
        momentum = None
        smooth = False
        meta = MappingProxyType({})

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        raise NotImplementedError(f"{type(self).__name__} defines no _evaluate")

    @synonyms.arguments(
        dict.fromkeys(("times", "time", "epoch", "epochs", "date", "dates"), "give t="),
        'motion.at(["2026-01-01", "2026-01-02"]) or motion.at(60.0), seconds since the epoch',
    )
    def at(self, t: Epochs, low: ArrayLike | None = None) -> AttitudeHistory:
        """The attitudes at some epochs.

        Parameters
        ----------
        t : array_like
            TDB seconds since the epoch of the motion (plain numbers or time Quantities), or epochs:
            astropy Time, skyfield Time, datetime, datetime64, ISO text in UTC, or lists of them.
            A scalar gives a scalar history; NaN gives NaN.
        low : array_like, optional
            With plain numbers: a second double; t + low are the seconds.

        Returns
        -------
        AttitudeHistory

        Raises
        ------
        AttitudeError
            For epochs that cannot be read, or outside of the span of the motion.
        """
        # asked once: attributes of classes that answer for absent ones take a share of one epoch
        epoch = self.epoch
        hi, lo = _inputs.seconds_since(epoch, t, low)
        # The history makes its arrays read-only, so the caller's arrays are copied.
        kept = None if lo is None else copied(lo)
        return self._history(hi if type(t) is float else copied(hi), kept, epoch)

    def at_seconds(self, seconds: FloatArray, low: FloatArray | None) -> AttitudeHistory:
        """As `at`, for arrays of TDB seconds, which the history keeps and makes read-only."""
        return self._history(seconds, low, self.epoch)

    def _history(
        self, seconds: FloatArray, low: FloatArray | None, epoch: _instants.Instant
    ) -> AttitudeHistory:
        arrays = self._evaluate(seconds, low, 0)
        history = AttitudeHistory(self, epoch, seconds, low, arrays[0])
        if len(arrays) > 1:
            history.__dict__["angular_velocity"] = frozen(arrays[1])
        return history

    def angular_velocity_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> FloatArray:
        """Angular velocity (..., 3), rad/s in body axes, at TDB seconds since the epoch."""
        hi, lo = _inputs.plain_seconds(seconds, low)
        return self._evaluate(hi, lo, 1)[1]

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: FloatArray | None = None,
    ) -> FloatArray:
        """Angular acceleration (..., 3), rad/s2 in body axes, at TDB seconds since the epoch.

        `angular_velocity` (..., 3), rad/s in body axes at the same epochs, saves motions with a
        body a second evaluation.
        """
        hi, lo = _inputs.plain_seconds(seconds, low)
        return self._evaluate(hi, lo, 2)[2]

    def turning_rate_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        wxyz: FloatArray,
        angular_velocity: FloatArray,
    ) -> FloatArray:
        """Rates (..., 3) at which attitudes turn, rad/s in body axes, at seconds since the epoch.

        Of attitudes (..., 4) and angular velocities (..., 3) there: those, but under an
        `InternalDissipation`, whose slip is added.
        """
        return angular_velocity

    def covariance_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None, *, rates: bool = True
    ) -> FloatArray:
        """Covariance at TDB seconds since the epoch, from that of the spin.

        (S, 6, 6): rotation vector of the attitude (rad, ICRF axes) and angular velocity (rad/s,
        body axes); without rates (S, 3, 3), of the attitude.

        Raises
        ------
        AttitudeError
            If the spin of the motion has no covariance, or the motion no derivatives.

        Warns
        -----
        CovarianceWarning
            Once for a motion: where a standard deviation of the attitude exceeds 60 deg, or the
            nonlinearity at the largest one (of free rotations) exceeds 0.5.
        """
        raise self._without_derivatives()

    def nonlinearity_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> FloatArray:
        """Second over first order (S,) of the errors; as `covariance_at`."""
        raise self._without_derivatives()

    @property
    def momentum_covariance(self) -> FloatArray:
        """(3, 3) covariance of `momentum`, in its unit squared, from that of the spin.

        AttitudeError as `covariance_at`, and for a momentum that changes.
        """
        raise self._without_derivatives()

    def momentum_covariance_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Covariance (S, 3, 3) of the momentum over ICRF axes, at TDB seconds since the epoch.

        AttitudeError as `covariance_at`, and for a body that changes.
        """
        raise self._without_derivatives()

    def _repr_html_(self) -> str:
        """A table for notebooks: the description, or the class and its span."""
        return markup.described(str(self), self.span)

    def _without_derivatives(self) -> AttitudeError:
        follow = "standard deviations and covariances follow from a FreeRotation whose spin has one"
        return AttitudeError(f"{self._kind} has no derivatives; {follow}.")

    @property
    def _kind(self) -> str:
        """Name of the class in error messages."""
        return type(self).__name__

    def body_at(self, t: EpochOrSeconds) -> Body | None:
        """The Body at one epoch, given as for `at`; None if the inertia is unknown."""
        return self.body

    def spin_at(self, epoch: EpochOrSeconds) -> Spin:
        """The state at one epoch, from which another motion may start.

        Parameters
        ----------
        epoch : epoch or seconds
            One, as `at` takes it.

        Returns
        -------
        Spin
            In the frame of the motion's spin (ICRF if it has none), with its covariance (to first
            order) if it has one.

        Raises
        ------
        AttitudeError
            For several epochs, and those that `at` refuses.
        """
        return synonyms.named("attitude.motions._free_rotation:spin_of")(self, epoch)

    @synonyms.arguments({}, 'published("L")')
    def published(
        self, convention: str, frame: str | None = None, at: EpochOrSeconds | None = None
    ) -> Published:
        """The free rotation at one epoch in the form of papers: mode, periods, pole, angles.

        Parameters
        ----------
        convention : "L" or "S"
            Whether phi is the angle of the long or of the short axis about the momentum.
        frame : str, optional
            Of the pole; by default the frame of the spin.
        at : epoch or seconds, optional
            Epoch of the angles; by default that of the motion.  Under torques, or along arcs, it is
            the free rotation that would follow from the state there.

        Returns
        -------
        Published
            ``Spin.from_periods(body, **published.keywords())`` makes the same spin.

        Raises
        ------
        AttitudeError
            For a motion without a body, a body at rest, and an unknown convention or frame.
        """
        return self._free_at(at)._published(convention, frame)

    def _free_at(self, at: EpochOrSeconds | None) -> Any:
        """The free rotation that would follow from the state at an epoch, by default the first."""
        time = 0.0 if at is None else at
        body = self.body_at(time)
        if body is None:
            raise AttitudeError(
                f"the form of papers follows from a body's inertia, but the motion ({self._kind}) "
                "has none; give a motion with a body."
            )
        free = synonyms.named("attitude.motions._free_rotation:FreeRotation")
        return free(body, self.spin_at(time))

    def constant_body(self, what: str) -> Body:
        """The Body that the motion has at all epochs.

        Parameters
        ----------
        what : str
            Name of the quantity computed from the body, for the error message.

        Raises
        ------
        AttitudeError
            If the motion has no body, or one that changes.
        """
        if self.body is None:
            raise AttitudeError(
                f"{what} follows from a body's inertia, but the motion ({type(self).__name__}) has "
                "none, or one that changes; give a motion with one body."
            )
        return self.body

    def momentum_in_body(self, history: AttitudeHistory) -> FloatArray:
        """Angular momentum (S, 3), kg m2/s over the body axes, at the epochs of a history.

        Raises
        ------
        AttitudeError
            If the motion has no body.
        """
        tensor = self.constant_body("the angular momentum").tensor
        return history.angular_velocity @ tensor

    @property
    def regime(self) -> Regime:
        """The `Regime` of a free rotation: its periods and ranges.

        Raises
        ------
        AttitudeError
            For any other motion.
        """
        raise AttitudeError(
            f"{type(self).__name__} has no regime, periods or mode; give a FreeRotation, such as "
            "FreeRotation(motion.body_at(t), motion.spin_at(t))."
        )

    def breaks(self) -> FloatArray:
        """The joints in two doubles of TDB seconds since the epoch, (N, 2)."""
        return np.stack([self.joints, np.zeros(len(self.joints))], axis=1)

    def rate_bounds(self, seconds: float) -> RateBounds | None:
        """Upper bounds that hold from TDB seconds since the epoch to the next joint, or None."""
        return None

    def has_rates_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> bool:
        """Whether angular velocities there are more exact than differences of attitudes.

        At TDB seconds + low since the epoch.
        """
        return True

    def plot(self, path: FilePath | None = None, **settings: Any) -> Any:
        """A figure of the polhode, the sky, angular velocity and Euler angles of a free rotation.

        Parameters
        ----------
        path : str or path, optional
            File of the picture to write, in a format of matplotlib.
        settings
            span=, frame= and title= of `attitude.plots.overview`.

        Returns
        -------
        matplotlib Figure
            In a notebook it shows itself.

        Raises
        ------
        AttitudeError
            For a motion that is no FreeRotation, and as `attitude.plots.overview`.
        """
        figure = synonyms.named("attitude.plots:overview")(self, **settings)
        return synonyms.named("attitude.plots:saved")(figure, path, dpi=100.0)

    def view(self, output: FilePath | None = None, **settings: Any) -> Any:
        """A page on which the body turns: `attitude.viewer.view` of this motion.

        Parameters
        ----------
        output : str or path, optional
            File to write, x.html; by default none.
        settings
            start=, stop=, shape=, title= and others of `attitude.viewer.view`.

        Returns
        -------
        attitude.viewer.Viewer
            In a notebook it shows itself.

        Raises
        ------
        AttitudeError
            As `attitude.viewer.view`.
        """
        return synonyms.named("attitude.viewer:view")(self, output=output, **settings)

    def write(self, path: FilePath, t: Epochs | None = None, **settings: Any) -> Any:
        """Write the motion in the format of the file's ending.

        Parameters
        ----------
        path : str or path
            m.toml (spin file, exact), m.apm, m.spin hold a free rotation; m.aem, m.a, m.csv,
            m.ecsv and others attitudes at epochs; m.bc a span.  docs/formats.md lists all endings.
            The file appears whole or not at all.
        t : epochs, optional
            Of a file of attitudes, as for `at`.  A table has its own.
        settings
            In place of t start=, stop= and tolerance= (rad); further arguments of the format's
            writer.

        Returns
        -------
        SampledFile, or what the writer of the format returns

        Raises
        ------
        AttitudeError
            For an ending of no format, a motion that the format cannot hold, and attitudes at
            epochs without t, or start=, stop= and tolerance=.
        """
        return synonyms.named("attitude.formats.detect:write_any")(path, self, t=t, **settings)

    def close(self) -> None:
        """Release the resources of the motion; a second call does nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class Foreign(Motion):
    """Any other object with ``.at(t)`` that returns an AttitudeHistory, as a Motion.

    wrapped: its seconds count from its ``epoch``, or from that of its ``spin``.  Its ``body``,
        ``momentum``, ``span`` and ``meta`` are used if it has them.
    """

    wrapped: Any

    def __init__(self, wrapped: Any) -> None:
        self._set_all(wrapped=wrapped, epoch=_epoch_of(wrapped))
        for name in ("body", "momentum", "span", "meta"):
            if getattr(wrapped, name, None) is not None:
                self._set(name, getattr(wrapped, name))

    @property
    def _kind(self) -> str:
        return type(self.wrapped).__name__

    def at(self, t: Epochs, low: ArrayLike | None = None) -> AttitudeHistory:
        """The attitudes at some epochs; see `Motion.at`."""
        return self.wrapped.at(t) if low is None else self.wrapped.at(t, low=low)

    def at_seconds(self, seconds: FloatArray, low: FloatArray | None) -> AttitudeHistory:
        """See `Motion.at_seconds`."""
        return self.at(seconds, low)

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        history = self.at(seconds, low)
        names = ("wxyz", "angular_velocity", "angular_acceleration")
        return [getattr(history, name) for name in names[: order + 1]]


def motion_of(motion: HasAttitudes, name: str = "motion") -> Motion:
    """The motion itself, or a `Foreign` motion of any other object with ``.at(t)``."""
    if isinstance(motion, Motion):
        return motion
    validation.refuse_class(motion, name)
    if not callable(getattr(motion, "at", None)):
        raise AttitudeError(
            f"{name} is {type(motion).__name__}; give a FreeRotation, or another object with "
            ".at(t) that returns an AttitudeHistory."
        )
    return Foreign(motion)


def _epoch_of(motion: Any) -> _instants.Instant:
    """The Instant from which the seconds of an object count."""
    for owner in (motion, getattr(motion, "spin", None)):
        epoch = getattr(owner, "epoch", None)
        if isinstance(epoch, _instants.Instant):
            return epoch
    raise AttitudeError(
        f"the motion ({type(motion).__name__}) has neither .epoch nor .spin, from which its "
        "seconds count; give it an Instant as .epoch."
    )
