"""Variables that do not go with the calls for doubles: integers, truth values, texts, and numbers of other widths.

They cost a call a type and a loop in Python, in units that have them alone. Numbers and truth values travel as doubles through
the buffers of `towage.units.wiring` (exact up to 2^53), texts and binaries as they are.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Sequence
from ctypes import Array, addressof
from typing import TYPE_CHECKING, Any

from towage.units.description import Variable

if TYPE_CHECKING:
    from towage.units.library import Instance

CTYPES: dict[str, Any] = {
    "Integer": c.c_int, "Boolean": c.c_int, "String": c.c_char_p,
    "Float32": c.c_float, "Int8": c.c_int8, "UInt8": c.c_uint8, "Int16": c.c_int16, "UInt16": c.c_uint16,
    "Int32": c.c_int32, "UInt32": c.c_uint32, "Int64": c.c_int64, "UInt64": c.c_uint64, "bool": c.c_bool,
    "Binary": c.c_void_p, "Float64": c.c_double, "Float64 discrete": c.c_double,
}  # fmt: skip
"""The C type of a value by ``Variable.kind``; "bool" is FMI 3's Boolean, "Integer" and "Boolean" are FMI 2's, and a discrete
double of FMI 3 is a kind of its own, because it is set in event mode alone."""
FUNCTIONS = {"bool": "Boolean", "Float64 discrete": "Float64"}
"""The type in the names of the calls, where it is not the kind."""
DOUBLES = ("Real", "Float64")
TEXTS = ("String", "Binary")
Text = str | bytes


class Group:
    """Variables of one kind that one call sets or gets. ``names`` in order; ``places`` are those of their values elsewhere
    (in a buffer of doubles, or in a list of outputs)."""

    def __init__(self, kind: str, variables: Sequence[Variable], places: Sequence[int]) -> None:
        self.kind = kind
        self.names = [v.name for v in variables]
        self.places = list(places)
        numbers = references_of(variables)
        self.references = (c.c_uint * len(numbers))(*numbers)
        self.values = (CTYPES[kind] * len(variables))()
        self.sizes = (c.c_size_t * len(variables))()
        self.function = FUNCTIONS.get(kind, kind)
        self.discrete = all(v.variability != "continuous" for v in variables)
        self.before: list[float | Text] | None = None
        self._alive: list[Any] = []

    def put(self, values: Sequence[float | Text]) -> None:
        """Values to be set. Raises ``ValueError`` for a number that the kind does not hold."""
        if self.kind == "Binary":
            self._alive = [c.create_string_buffer(bytes(v), len(v) + 1) for v in map(_binary, values)]
            self.sizes[:] = [len(_binary(v)) for v in values]
            self.values[:] = [addressof(buffer) for buffer in self._alive]
        elif self.kind == "String":
            self._alive = [str(v).encode() for v in values]
            self.values[:] = self._alive
        elif self.kind.startswith("Float"):
            self.values[:] = [float(v) for v in values]
        else:
            numbers = [round(float(v)) for v in values]
            self.values[:] = numbers
            for name, wanted, held in zip(self.names, numbers, self.values):
                if wanted != held:
                    raise ValueError(f"{name} is {self.kind}, which does not hold {wanted}")

    def taken(self) -> list[float | Text]:
        """The values that were got."""
        if self.kind == "String":
            return [(value or b"").decode(errors="replace") for value in self.values]
        if self.kind == "Binary":
            return [c.string_at(at, size) if at else b"" for at, size in zip(self.values, self.sizes)]
        if self.kind == "Boolean":
            return [float(value != 0) for value in self.values]  # some say -1, or 2
        return [float(value) for value in self.values]


def is_double(v: Variable) -> bool:
    """Whether the variable is one double, which a call for doubles reads."""
    return v.array == 1 and v.kind.partition(" ")[0] in DOUBLES


def references_of(variables: Sequence[Variable]) -> list[int]:
    """What a call for these variables names: each of them, an array once, whose elements follow one another. Two names of one
    variable are two."""
    alone = (v.array == 1 or k == 0 or v.value_reference != variables[k - 1].value_reference for k, v in enumerate(variables))
    return [v.value_reference for v, named in zip(variables, alone) if named]


def _binary(value: float | Text) -> bytes:
    """A binary as it is; a text, as a scene writes it, is read as hexadecimal digits."""
    return value if isinstance(value, bytes) else bytes.fromhex(str(value))


def groups(variables: Sequence[Variable], places: Sequence[int]) -> list[Group]:
    """The variables by kind, in order, with their places."""
    made = []
    for kind, smooth in dict.fromkeys((v.kind, v.variability == "continuous") for v in variables):
        alike = (v.kind == kind and (v.variability == "continuous") == smooth for v in variables)
        chosen = [(v, place) for v, place, fits in zip(variables, places, alike) if fits]
        made.append(Group(kind, [v for v, _ in chosen], [place for _, place in chosen]))
    return made


class Others:
    """The groups of a unit: ``inputs`` are numbers in the buffer of doubles, ``outputs`` go behind the other values;
    ``texts_in`` and ``texts_out`` are texts, whose values are in ``words`` by name."""

    def __init__(self, inputs: list[Group], outputs: list[Group], texts_in: list[Group], texts_out: list[Group]) -> None:
        self.inputs, self.outputs, self.texts_in, self.texts_out = inputs, outputs, texts_in, texts_out
        self.words: dict[str, Text] = {n: "" for group in (*texts_in, *texts_out) for n in group.names}
        self.any_in, self.any_out = bool(inputs or texts_in), bool(outputs or texts_out)

    def set(self, instance: Instance, buffer: Array[c.c_double], check: Callable[[int], None]) -> None:
        """Pass the inputs on. Raises ``ValueError`` for a number that an input does not hold."""
        for group in (*self.inputs, *self.texts_in):
            texts = group.kind in TEXTS
            group.put([self.words[n] for n in group.names] if texts else [buffer[k] for k in group.places])
            check(instance.set_kind(group))

    def get(self, instance: Instance, count: int, check: Callable[[int], None]) -> list[float]:
        """Read the outputs: the ``count`` numbers; texts go to ``words``."""
        values = [0.0] * count
        for group in self.outputs:
            check(instance.get_kind(group))
            for place, value in zip(group.places, group.taken()):
                values[place] = float(value)
        for group in self.texts_out:
            check(instance.get_kind(group))
            for name, text in zip(group.names, group.taken()):
                self.words[name] = text if isinstance(text, bytes) else str(text)
        return values
