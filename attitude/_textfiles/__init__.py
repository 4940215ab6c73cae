"""Readers and writers of text and XML; no other package of `attitude` opens or parses text.

lines          lines, whole texts and columns of numbers; errors name the file and the line
messages       CCSDS messages as tables of keywords, in KVN and XML
xml            XML without document types and entities
toml           TOML; errors for its syntax and for unknown keys; JSON values and rows of CSV
atomic_write   files that appear whole or not at all
kept_arrays    arrays that took long to compute, kept on disk
"""
