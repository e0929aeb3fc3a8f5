"""Errors in the input, with a message of one line."""


class BadInput(Exception):
    """An error that the program prints before it ends with exit code 2."""
