"""Mission files as text."""

# A top seen and lit from directions at infinity: everything is known in closed form.
FIXED = """
observer.direction = [1, 0, 0]
sun.direction = [1, 1, 0]

[body]
moments = [1, 2, 3]
relative = true

[spin]
epoch = "2026-01-01"
wxyz = [1, 0, 0, 0]
angular_velocity = "0, 0, 1 deg/s"

[shape]
ellipsoid = "3, 2, 1 m"

[times]
start = "0"
stop = "360 s"
step = "30 s"
"""
