"""Parts that several CCSDS messages share, and that STK and CSV files use too.

epochs           time codes A and B
attitude_types   the columns of each attitude type; versions and header of messages
"""
