# OpenMV's module for pictures, for the example find_template_that_follows.py: there is no picture.
SEARCH_EX = None


def Image(path):
    raise OSError(path)
