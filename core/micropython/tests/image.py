# Stands in for OpenMV's module `image` in the example: the template exists if the environment has SMR_TEMPLATE.
import os

SEARCH_EX = None


def Image(path):
    if os.getenv("SMR_TEMPLATE") is None:
        raise OSError(path)
    return path
