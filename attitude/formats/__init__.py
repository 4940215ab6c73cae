"""Files in and out: one module a format, each imported by those who read or write it."""
