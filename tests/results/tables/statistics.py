"""Means over recordings with standard errors, shares over frames, and paired differences."""

from math import sqrt


def mean_and_error(values):
    """The mean of the values and its standard error."""
    mean = sum(values) / len(values)
    variance = sum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1)
    return mean, sqrt(variance / len(values))


def plus_minus(values, sign=""):
    """For example `0.774 +- 0.031`; with the sign `+`, `+0.019 +- 0.012`."""
    mean, error = mean_and_error(values)
    return f"{mean:{sign}.3f} +- {error:.3f}"


def percent(part, whole, digits=0):
    return f"{100 * part / whole:.{digits}f} %" if whole else "-"


class Recordings:
    """The figures of one tracker, a row for each recording."""

    def __init__(self, rows):
        self.rows = {(row["folder"], row["sequence"]): row for row in rows}

    def of(self, folder):
        """The recordings of one folder."""
        return Recordings([row for row in self.rows.values() if row["folder"] == folder])

    def __add__(self, other):
        return Recordings([*self.rows.values(), *other.rows.values()])

    def __len__(self):
        return len(self.rows)

    def values(self, name):
        return [row[name] for row in self.rows.values()]

    def mean(self, name):
        return f"{mean_and_error(self.values(name))[0]:.3f}"

    def with_error(self, name):
        return plus_minus(self.values(name))

    def sum(self, name):
        return sum(self.values(name))

    def share(self, part, whole):
        """A share of all frames, in per cent."""
        return percent(self.sum(part), self.sum(whole))

    def against(self, other, name):
        """The mean difference to another tracker on the same recordings."""
        return plus_minus([row[name] - other.rows[key][name] for key, row in self.rows.items()], "+")
