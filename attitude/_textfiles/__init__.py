"""Readers and writers of text and XML; no other package of `attitude` opens or parses text.

lines          lines, whole texts and columns of numbers; errors name the file and the line
kvn            the KEYWORD = value notation of CCSDS messages
xml            XML without document types and entities
toml           TOML; errors for its syntax and for unknown keys; JSON values and rows of CSV
atomic_write   files that appear whole or not at all
"""
