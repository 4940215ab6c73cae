"""Reading and writing of text files and XML: the only package that does.

lines          text files by line or as a whole, with sentences that name file and line
kvn            the KEYWORD = value notation of CCSDS messages
xml            XML without document types or entities
records        JSON values and rows of CSV
toml           TOML with sentences for syntax and unknown keys
quantities     numbers with units in text
atomic_write   files that appear whole or not at all
"""
