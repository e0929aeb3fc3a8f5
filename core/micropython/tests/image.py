# OpenMV's module for pictures, for the example: there is a template if the environment has SMR_TEMPLATE.
import os

SEARCH_EX = None


def Image(path):
    if os.getenv("SMR_TEMPLATE") is None:
        raise OSError(path)
    return path
