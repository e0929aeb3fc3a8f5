"""Errors of the input, in one line for people."""


class BadInput(Exception):
    """The program prints it and ends with exit code 2."""
