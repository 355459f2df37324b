"""C structs as Python objects: settings that callers fill in, results that calls give, records of arrays."""
from __future__ import annotations

import dataclasses
import difflib
import textwrap
from collections.abc import Mapping
from typing import Any, ClassVar, Optional

import numpy as np

from tulle import _library
from tulle._arrays import point_to, to_doubles, to_indices, to_vector
from tulle._library import ffi
from tulle.errors import InvalidArgumentError

_structs: dict[str, type[Settings]] = {}  # by C name
_makers: dict[str, Any] = {}              # the default of a C struct


def decode(text: Any) -> str:
    """Text of the library: a pointer or an array of characters."""
    return "" if text == ffi.NULL else str(ffi.string(text), errors="replace")


def _make_struct(name: str) -> Any:
    """A new C struct with its defaults, as a pointer."""
    made = _makers.get(name)
    if made is None:
        kind = _structs.get(name)
        made = ffi.new(name + " *")
        if kind is not None and kind._maker:
            made[0] = getattr(_library.io if "subdivision" in kind._maker else _library.core, kind._maker)()
        elif kind is not None and kind._within:
            name_of_whole, path = kind._within
            whole = _make_struct("tulle_" + name_of_whole)  # which holds the memory that its parts lie in
            source: Any = whole
            for part in path.split("."):
                source = getattr(source, part)
            made[0] = source
        _makers[name] = made
    return ffi.new(name + " *", made[0])


def _class_of(value: Any) -> type[Settings]:
    """The Python class of a C struct."""
    return _structs[ffi.typeof(value).cname.replace("struct ", "").rstrip(" &*").removeprefix("const ")]


def default(name: str, field: str) -> Any:
    """The field of a dataclass whose default is that of the C struct."""
    def read() -> Any:
        kind = _structs["tulle_" + name]
        return _read(kind, _make_struct(kind._struct), field)
    return dataclasses.field(default_factory=read)


def _enum_of(struct: str, field: str) -> Any:
    """The Python class of an enum field."""
    from tulle import structs  # of which this module is the base
    name = dict(ffi.typeof(struct).fields)[field].type.cname.replace("enum ", "").removeprefix("tulle_")
    return getattr(structs, "".join(part.capitalize() for part in name.split("_")))


def _read(kind: type[Settings], source: Any, field: str) -> Any:
    """A field of a C struct as Python has it."""
    how = kind._fields[field]
    value = getattr(source, field) if how != "array" else None
    if how == "array":
        return () if kind._arrays[field][0][0].isupper() else None
    if how == "enum":
        return _enum_of(kind._struct, field)(value)
    if how == "pointer":
        return None if value == ffi.NULL else _class_of(value).from_c(value)
    if how == "struct":
        inner = _class_of(value)
        return inner.from_c(value)
    if how == "vector":
        return tuple(value)
    if how == "bool":
        return bool(value)
    if how == "text":
        return decode(value) or None
    return value


def refuse_unknown(names: Any, known: Any, what: str) -> None:
    """Refuses a name that is not known, and tells the nearest one."""
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, list(known), 1)
            hint = f"did you mean \"{near[0]}\"?" if near else f"it has {', '.join(known)}"
            raise TypeError(f"{what} has no \"{name}\"; {hint}")


def to_enum(kind: Any, value: Any, what: str) -> Any:
    """A value of an enum: one of it, its name in small or capital letters, or its number."""
    if isinstance(value, str):
        wanted = value.upper().replace("-", "_")
        if wanted not in kind.__members__:
            names = ", ".join(f'"{name.lower()}"' for name in kind.__members__)
            raise InvalidArgumentError(f"{what} is \"{value}\"; it should be one of {names}")
        return kind[wanted]
    try:
        return kind(value)
    except (ValueError, TypeError):
        names = ", ".join(f"{kind.__name__}.{name}" for name in kind.__members__)
        raise InvalidArgumentError(f"{what} is {value!r}; it should be one of {names}") from None


class Settings:
    """The base of what calls are given. All subclasses are dataclasses, made from the headers."""

    _struct: ClassVar[str] = ""
    _maker: ClassVar[Optional[str]] = None
    _within: ClassVar[Optional[tuple[str, str]]] = None
    _fields: ClassVar[dict[str, str]] = {}
    _words: ClassVar[dict[str, str]] = {}
    _arrays: ClassVar[dict[str, tuple[str, int, Optional[str]]]] = {}

    def __init_subclass__(cls) -> None:
        _structs[cls._struct] = cls
        lines = [textwrap.fill(f"{field}: {words}", 100, subsequent_indent="    ") for field, words in cls._words.items()]
        cls.__doc__ = "\n".join([cls.__doc__ or "", "", *lines])

    @classmethod
    def make(cls, given: Any, changes: Mapping[str, Any], what: str) -> Any:
        """`given`, or the defaults where it is None, with `changes` by name; a mapping is changes on the defaults."""
        if isinstance(given, Mapping):
            refuse_unknown(given, cls._fields, what)
            given = cls(**given)
        if given is not None and not isinstance(given, cls):
            raise TypeError(f"{what} should be a {cls.__name__} or a dictionary, not a {type(given).__name__}")
        refuse_unknown(changes, cls._fields, what)
        if given is None:
            return cls(**changes)
        return dataclasses.replace(given, **changes)

    @classmethod
    def from_c(cls, source: Any) -> Any:
        """The settings that a C struct holds; its arrays are left out."""
        return cls(**{field: _read(cls, source, field) for field in cls._fields})

    def to_c(self, keep: list[Any]) -> Any:
        """A pointer to the C struct; `keep` gets what must live as long as it is used."""
        made = _make_struct(self._struct)
        self.fill(made, keep, type(self).__name__)
        keep.append(made)
        return made

    def fill(self, target: Any, keep: list[Any], what: str) -> None:
        """Fills a C struct."""
        for field, how in self._fields.items():
            value, place = getattr(self, field), f"{what}.{field}"
            if how == "array":
                self._fill_array(target, field, value, keep, place)
            elif how == "enum":
                setattr(target, field, int(to_enum(_enum_of(self._struct, field), value, place)))
            elif how == "struct":
                inner = getattr(target, field)
                _class_of(inner).make(value, {}, place).fill(inner, keep, place)
            elif how == "pointer":
                if value is not None:
                    setattr(target, field, _class_of(getattr(target, field)).make(value, {}, place).to_c(keep))
            elif how == "vector":
                row = getattr(target, field)
                row[0:len(row)] = to_vector(value, place, len(row)).tolist()
            elif how == "text":
                if value is not None and not isinstance(value, str):
                    raise TypeError(f"{place} should be text, not a {type(value).__name__}")
                if value is not None and "\0" in value:
                    raise InvalidArgumentError(f"{place} holds a zero byte")
                text = ffi.NULL if value is None else ffi.new("char[]", value.encode())
                keep.append(text)
                setattr(target, field, text)
            else:
                try:
                    setattr(target, field, bool(value) if how == "bool" else value)
                except (TypeError, OverflowError) as failure:
                    raise InvalidArgumentError(f"{place} is {value!r}: {failure}") from None

    def _fill_array(self, target: Any, field: str, value: Any, keep: list[Any], what: str) -> None:
        element, columns, count_field = self._arrays[field]
        count, pointer = 0, ffi.NULL
        if element[0].isupper():
            kind = next(each for each in _structs.values() if each.__name__ == element)
            values = list(value)
            count, made = len(values), ffi.new(f"{kind._struct}[]", len(values) or 1)
            for i, each in enumerate(values):
                made[i] = _make_struct(kind._struct)[0]  # with its cookie
                kind.make(each, {}, f"{what}[{i}]").fill(made[i], keep, f"{what}[{i}]")
            keep.append(made)
            pointer = made if count else ffi.NULL
        elif value is not None:
            if element == "double":
                array: Any = to_doubles(np.reshape(value, (-1, columns)) if columns == 9 else value, columns, what)
            elif element == "uint8":
                array = np.ascontiguousarray(value, dtype=np.uint8)
            else:
                array = to_indices(value, columns, what)
            keep.append(array)
            count = array.shape[0]
            names = {"double": "double *", "uint32": "uint32_t *", "uint8": "unsigned char *"}
            pointer = point_to(array, names[element])
        setattr(target, field, pointer)
        if count_field:
            setattr(target, count_field, count)


class Result:
    """The base of what calls give: it reads the fields of a C struct when they are asked for."""

    __slots__ = ("_c", "_owner")
    _fields: ClassVar[tuple[str, ...]] = ()

    def __init__(self, c: Any, owner: Any = None) -> None:
        self._c, self._owner = c, owner

    def to_dict(self) -> dict[str, Any]:
        """All fields by name; those that are structs themselves as dictionaries."""
        values = {field: getattr(self, field) for field in self._fields}
        return {field: value.to_dict() if isinstance(value, Result) else value for field, value in values.items()}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{field}={getattr(self, field)!r}' for field in self._fields)})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        kind = ffi.typeof(self._c)
        kind = kind.item if kind.kind == "pointer" else kind
        if any(entry.type.kind == "pointer" for _, entry in kind.fields):
            raise TypeError(f"a {type(self).__name__} cannot be pickled; take its to_dict()")
        whole = self._c if ffi.typeof(self._c).kind == "pointer" else ffi.addressof(self._c)
        return _restore, (type(self), kind.cname.replace("struct ", ""), bytes(ffi.buffer(whole, ffi.sizeof(kind))))


def _restore(cls: type[Result], kind: str, data: bytes) -> Result:
    """A result that was pickled."""
    made = ffi.new(kind + " *")
    ffi.buffer(made)[:] = data
    return cls(made)


def _make_format(kind: Any) -> Any:
    if kind.kind == "array":
        return _make_format(kind.item), (kind.length,)
    if kind.kind == "struct":
        return make_record(kind.cname.replace("struct ", ""))
    if kind.kind == "enum":
        return np.dtype(np.uint32)
    names = {"double": "f8", "float": "f4", "int": "i4", "long": "i8", "unsigned int": "u4", "unsigned char": "u1",
             "uint32_t": "u4", "int32_t": "i4", "uint64_t": "u8", "int64_t": "i8", "size_t": "u8", "char": "S1"}
    return np.dtype(names[kind.cname])


def make_record(name: str) -> np.dtype[Any]:
    """The type of an array of C structs."""
    fields = ffi.typeof(name).fields
    return np.dtype({"names": [field for field, _ in fields], "formats": [_make_format(entry.type) for _, entry in fields],
                     "offsets": [entry.offset for _, entry in fields], "itemsize": ffi.sizeof(name)})
