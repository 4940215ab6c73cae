"""The CSV of attitudes: its columns, and rows whose numbers are read back as the same doubles."""

ATTITUDE = ("w", "x", "y", "z")
RATES = ("omega_x", "omega_y", "omega_z")


def names(*, rates):
    """The columns: UTC, TDB seconds, the attitude and, if asked for, the angular velocity."""
    return ["utc", "tdb_seconds", *ATTITUDE, *(RATES if rates else ())]


def of_history(dates, seconds, history, *, rates):
    """The text of the rows of a history, under `names`."""
    columns = [*history.wxyz.T, *(history.angular_velocity.T if rates else ())]
    return text(dates, seconds.tolist(), *(column.tolist() for column in columns))


def text(dates, *columns):
    """The text of rows: dates, and lists of numbers."""
    pattern = "%s" + ",%r" * len(columns) + "\n"
    return "".join([pattern % row for row in zip(dates, *columns, strict=True)])
