"""What CCSDS messages have in common: time codes, attitude types, axes.

epochs           time codes A and B
attitude_types   the columns of each attitude type
axes             reference axes by name
"""
