"""Reference axes by name: inertial, of the Earth, of an orbit; attitudes and rates in them.

axes           `Axes`: orientation relative to ICRF and angular velocity
axis_names     names of axes in files and elsewhere
orbit_axes     axes of an orbit; `earth_axes`, of the Earth
framed         a history relative to axes
"""
