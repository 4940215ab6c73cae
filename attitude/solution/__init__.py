"""The exact free rotation on plain arrays: no units, no time scales, no objects.

Importing this package compiles nothing; each function is compiled at its first call and kept on
disk for the next process.
"""
