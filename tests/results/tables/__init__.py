"""The tables that `measure` knows, in the order in which it measures them."""

from . import accuracy, cost, faults, pico
from .programs import Skipped
from .table import Table

TABLES: dict[str, Table] = {table.name: table for module in (accuracy, faults, cost, pico) for table in module.TABLES}

__all__ = ["TABLES", "Skipped"]
