"""How the laws that are evaluated facet by facet are numbered in rows for compiled code."""

# (code, w, g, b0, h, roughness)
HAPKE = 0.0
# (code, diffuse, specular, exponent)
PHONG = 1.0
# (code, diffuse, specular, roughness, f0)
COOK_TORRANCE = 2.0
WIDTH = 6
