"""Conversion of Python objects to what the extension module reads."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any, Union

import numpy as np

#: Path of a file of keys, name of a built-in scenario, or the content as a dictionary.
Source = Union[str, "os.PathLike[str]", Mapping[str, Any]]
#: Path of a log, or its columns: a mapping or a data frame.
Log = Union[str, "os.PathLike[str]", Mapping[str, Any], Any]


def source_of(source: Source) -> tuple[str, bool]:
    """Text, and true for the content of a file."""
    if isinstance(source, (str, os.PathLike)):
        return os.fspath(source), False
    return json.dumps(source, default=_plain), True


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is no value of a key")


def columns_of(log: Log) -> Any:
    """Path, or pairs of name and column: float64 arrays, or texts."""
    if isinstance(log, (str, os.PathLike)):
        return os.fspath(log)
    if not hasattr(log, "columns") and not isinstance(log, Mapping):
        raise ValueError(
            f"log: {type(log).__name__} without named columns; "
            "give a data frame, a dictionary of columns or the path of a file"
        )
    names = log.columns if hasattr(log, "columns") else log.keys()
    return [(str(name), _column(log[name])) for name in names]


def _column(values: Any) -> Any:
    array = np.asarray(values)
    if array.ndim != 1:
        raise ValueError(f"log: a column of shape {array.shape}; give one dimension")
    if array.dtype.kind == "f":
        return np.ascontiguousarray(array, dtype=np.float64)
    if array.dtype.kind == "M":
        return [str(time) for time in np.datetime_as_string(array)]
    # Integers keep all digits as texts: time stamps in ns exceed the 53 bits of a float.
    return ["" if value is None else str(value) for value in array.tolist()]
