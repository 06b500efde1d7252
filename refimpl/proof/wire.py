"""Certificates as JSON: numbers stay exactly what they are.

A double is a JSON number (its shortest decimal form names it), a rational a string "p/q", and infinity the
string "inf" or "-inf". What is read back is only known to be well-formed; `check` decides what it is worth.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from refimpl.proof.claims import (
    Bound,
    Certificate,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    Near,
    Part,
    Piece,
    Place,
    Separated,
    Simple,
    Split,
    Tree,
    Weights,
)
from refimpl.proof.impacts import Impact, ImpactCertificate, MovingBody, Outcome, Residuals
from refimpl.proof.rational import MAX_BITS, MAX_ITEMS, InvalidCertificate
from refimpl.proof.rigid import Boxes, Span, Spans, Touch
from refimpl.proof.sweeps import Clear, Meets, SweepCertificate
from refimpl.proof.triangles import TouchCertificate
from refimpl.proof.vectors import Number, Vector

DECIMAL_BITS = 12_000  # Python turns only about 4300 digits into decimals; longer numbers are written to base 16
INTEGER = "(?:0|[1-9][0-9]{0,3999}|0x[0-9a-f]+)"
RATIONAL = re.compile(f"-?{INTEGER}(?:/{INTEGER})?")


def to_json(certificate: Certificate) -> dict[str, Any]:
    """Turn a certificate into what ``json.dumps`` takes."""
    claims = [_encode(claim) for claim in certificate.claims]
    return {"lower": _encode(certificate.lower), "upper": _encode(certificate.upper), "claims": claims}


def from_json(data: Any) -> Certificate:
    """Read what `to_json` gave.

    Raises
    ------
    InvalidCertificate
        For anything else: another structure, unknown kinds or fields, too many or too long numbers.
    """
    fields = _mapping(data, ("lower", "upper", "claims"), "certificate")
    try:
        claims = tuple(_read(item, CLAIMS) for item in _items(fields.get("claims"), "claims"))
    except RecursionError:
        raise InvalidCertificate("nested too deeply") from None
    lower, upper = fields.get("lower", "-inf"), fields.get("upper", "inf")
    return Certificate(claims, _bound(lower, "lower"), _bound(upper, "upper"))


def impact_to_json(certificate: ImpactCertificate) -> dict[str, Any]:
    """Turn a certificate of an impact into what ``json.dumps`` takes."""
    encoded: dict[str, Any] = _encode(certificate)
    return encoded


def certificate_to_json(certificate: Certificate | ImpactCertificate | SweepCertificate) -> dict[str, Any]:
    """Turn a certificate of any kind into what ``json.dumps`` takes."""
    if isinstance(certificate, SweepCertificate):
        return sweep_certificate_to_json(certificate)
    return impact_to_json(certificate) if isinstance(certificate, ImpactCertificate) else to_json(certificate)


def sweep_certificate_to_json(certificate: SweepCertificate) -> dict[str, Any]:
    """Turn a certificate of a first contact into what ``json.dumps`` takes."""
    encoded: dict[str, Any] = _encode(certificate)
    return encoded


def sweep_certificate_from_json(data: Any) -> SweepCertificate:
    """Read what `sweep_certificate_to_json` gave; raises InvalidCertificate for anything else."""
    try:
        found: SweepCertificate = _read(data, ("sweep certificate",))
    except RecursionError:
        raise InvalidCertificate("nested too deeply") from None
    return found


def touch_to_json(certificate: TouchCertificate) -> dict[str, Any]:
    """Turn a certificate of a first contact of moving triangles into what ``json.dumps`` takes."""
    encoded: dict[str, Any] = _encode(certificate)
    return encoded


def touch_from_json(data: Any) -> TouchCertificate:
    """Read what `touch_to_json` gave; raises InvalidCertificate for anything else."""
    found: TouchCertificate = _read(data, ("touch certificate",))
    return found


def impact_from_json(data: Any) -> ImpactCertificate:
    """Read what `impact_to_json` gave; raises InvalidCertificate for anything else."""
    found: ImpactCertificate = _read(data, ("impact certificate",))
    return found


def _encode(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_encode(v) for v in value]
    if type(value) in NAMES:
        return {"kind": NAMES[type(value)], **{key: _encode(v) for key, v in vars(value).items()}}
    if isinstance(value, Fraction):
        return f"{_digits(value.numerator)}/{_digits(value.denominator)}"
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, int) and abs(value) > 1 << 53:  # not every reader of JSON keeps it
        return _digits(value)
    return value


def _digits(value: int) -> str:
    return str(value) if value.bit_length() <= DECIMAL_BITS else hex(value)


def _read(data: Any, names: tuple[str, ...]) -> Any:
    name = data.get("kind") if isinstance(data, dict) else None
    if not isinstance(name, str) or name not in names:
        raise InvalidCertificate(f"expected an object whose kind is one of {', '.join(names)}")
    kind, parts = KINDS[name]
    fields = _mapping(data, ("kind", *parts), name)
    return kind(**{part: parse(fields.get(part), f"{name}.{part}") for part, parse in parts.items()})


def _mapping(data: Any, names: tuple[str, ...], what: str) -> dict[str, Any]:
    if not isinstance(data, dict) or not set(data) <= set(names):
        raise InvalidCertificate(f"{what}: expected an object with the names {', '.join(names)}")
    return data


def _items(data: Any, what: str, count: int | None = None) -> list[Any]:
    if not isinstance(data, list) or len(data) > MAX_ITEMS or (count is not None and len(data) != count):
        raise InvalidCertificate(f"{what}: expected a list of {count or f'at most {MAX_ITEMS}'} items")
    return data


def _number(data: Any, what: str) -> Number:
    if isinstance(data, str) and len(data) <= MAX_BITS and RATIONAL.fullmatch(data):
        numerator, _, denominator = data.partition("/")
        divisor = int(denominator, 0) if denominator else 1
        if divisor:
            return Fraction(int(numerator, 0), divisor)
    elif type(data) is int or (isinstance(data, float) and math.isfinite(data)):
        return data
    raise InvalidCertificate(f"{what}: expected a finite number, or a rational such as '1/3'")


def _bound(data: Any, what: str) -> Bound:
    if data in ("inf", "-inf"):
        return float(data)
    number = _number(data, what)
    return number if isinstance(number, float) else Fraction(number)


def _optional_number(data: Any, what: str) -> Number | None:
    return None if data is None else _number(data, what)


def _vector(data: Any, what: str) -> Vector:
    x, y, z = (_number(v, what) for v in _items(data, what, 3))
    return x, y, z


def _columns(data: Any, what: str) -> tuple[Vector, Vector, Vector]:
    x, y, z = (_vector(column, what) for column in _items(data, what, 3))
    return x, y, z


def _weights(data: Any, what: str) -> Weights:
    pairs = [_items(pair, what, 2) for pair in _items(data, what)]
    return tuple((_index(i, what), _number(weight, what)) for i, weight in pairs)


def _shares(data: Any, what: str) -> tuple[Number, Number, Number]:
    of_a, of_b, of_both = (_number(share, what) for share in _items(data, what, 3))
    return of_a, of_b, of_both


def _place(data: Any, what: str) -> Place:
    """Coordinates, or the weights of vertices."""
    by_weights = isinstance(data, list) and all(isinstance(item, list) for item in data)
    return _weights(data, what) if by_weights else _vector(data, what)


def _optional_place(data: Any, what: str) -> Place | None:
    return None if data is None else _place(data, what)


def _pairs(data: Any, what: str) -> tuple[tuple[Place, Place], ...]:
    pairs = [_items(pair, what, 2) for pair in _items(data, what)]
    return tuple((_place(p, what), _place(q, what)) for p, q in pairs)


def _index(data: Any, what: str) -> int:
    if type(data) is not int:
        raise InvalidCertificate(f"{what}: expected indices")
    return data


def _triangles(data: Any, what: str) -> tuple[tuple[int, int, int], ...]:
    triangles = [[_index(i, what) for i in _items(triangle, what, 3)] for triangle in _items(data, what)]
    return tuple((i, j, k) for i, j, k in triangles)


def _flag(data: Any, what: str) -> bool:
    if not isinstance(data, bool):
        raise InvalidCertificate(f"{what}: expected true or false")
    return data


def _tree(data: Any, _: str) -> Tree:
    found: Tree = _read(data, ("split", "separated"))
    return found


def _branches(data: Any, what: str) -> tuple[Tree, Tree]:
    one, other = _items(data, what, 2)
    return _tree(one, what), _tree(other, what)


def _numbers(data: Any, what: str) -> tuple[int, ...]:
    return tuple(_index(i, what) for i in _items(data, what))


def _polynomial(data: Any, what: str) -> tuple[int, ...] | None:
    if data is None:
        return None
    numbers = [_number(c, what) for c in _items(data, what)]
    if not all(isinstance(c, int | Fraction) and c.denominator == 1 for c in numbers):
        raise InvalidCertificate(f"{what}: expected whole numbers")
    return tuple(int(c) for c in numbers)


def _times(data: Any, what: str) -> tuple[tuple[Number, int], ...]:
    pairs = [_items(pair, what, 2) for pair in _items(data, what)]
    return tuple((_number(until, what), _index(which, what)) for until, which in pairs)


def _vectors(data: Any, what: str) -> tuple[Vector, ...]:
    return tuple(_vector(v, what) for v in _items(data, what))


def _places(data: Any, what: str) -> tuple[tuple[Place, ...], tuple[Place, ...]]:
    of_a, of_b = (tuple(_place(place, what) for place in _items(side, what)) for side in _items(data, what, 2))
    return of_a, of_b


def _choice(data: Any, what: str) -> int | tuple[int, Piece] | None:
    if data is None or type(data) is int:
        return data
    number_of, piece = _items(data, what, 2)
    return _index(number_of, what), _read(piece, ("piece",))


def _simple(data: Any, _: str) -> Simple:
    found: Simple = _read(data, SIMPLE)
    return found


def _face_lists(data: Any, what: str) -> Any:
    """Shares of the planes of atoms, by their numbers."""
    pairs = [[_items(entry, what, 2) for entry in _items(side, what)] for side in _items(data, what, 2)]
    return tuple(tuple((_index(i, what), _weights(weights, what)) for i, weights in side) for side in pairs)


def _one(name: str) -> Callable[[Any, str], Any]:
    """Reader of an object of one kind."""
    return lambda data, _: _read(data, (name,))


def _sweep_claims(data: Any, what: str) -> tuple[Any, ...]:
    return tuple(_read(item, SWEEP_CLAIMS) for item in _items(data, what))


def _all_of(name: str) -> Callable[[Any, str], tuple[Any, ...]]:
    """Reader of a list of objects of one kind."""
    return lambda data, what: tuple(_read(item, (name,)) for item in _items(data, what))


def _six_weights(data: Any, what: str) -> tuple[Any, ...]:
    """Six lists of shares of the planes of atoms, by their numbers."""
    pairs = [_items(entry, what, 2) for entry in _items(data, what)]
    return tuple((_index(i, what), tuple(_weights(w, what) for w in _items(six, what, 6))) for i, six in pairs)


def _claim(data: Any, _: str) -> Any:
    return _read(data, CLAIMS)


def _optional_columns(data: Any, what: str) -> tuple[Vector, Vector, Vector] | None:
    return None if data is None else _columns(data, what)


KINDS: dict[str, tuple[type[Any], dict[str, Callable[[Any, str], Any]]]] = {
    "separated": (Separated, {"n": _vector, "until": _optional_number, "faces": _face_lists}),
    "escape": (Escape, {"n": _vector, "faces": _face_lists}),
    "near": (Near, {"a": _place, "b": _place}),
    "common": (Common, {"p": _optional_place, "time": _optional_number}),
    "core": (Core, {"pairs": _pairs, "triangles": _triangles, "directions": _flag}),
    "inscribed": (
        Inscribed,
        {"a": _place, "p": _columns, "b": _place, "q": _columns, "radius": _number, "shares": _shares},
    ),
    "cover": (Cover, {"tree": _tree, "shift": _vector, "places": _places, "until": _optional_number}),
    "part": (Part, {"of_a": _choice, "of_b": _choice, "claim": _simple}),
    "split": (Split, {"side": _index, "first": _numbers, "branches": _branches}),
    "piece": (Piece, {"vertices": _vectors, "tree": _tree, "radius": _number}),
    "clear": (Clear, {"tree": _tree, "until": _optional_number, "places": _places}),
    "meets": (Meets, {"time": _number, "a": _place, "b": _place, "of_a": _choice, "of_b": _choice}),
    "span": (Span, {"before": _tree, "after": _tree, "until": _optional_number}),
    "spans": (Spans, {"spans": _all_of("span"), "places": _places}),
    "boxes": (Boxes, {"of_a": _six_weights, "of_b": _six_weights}),
    "touch": (Touch, {"time": _number, "claim": _claim}),
    "sweep certificate": (SweepCertificate, {"claims": _sweep_claims, "lower": _bound, "upper": _bound}),
    "touch certificate": (TouchCertificate, {"cover": _times, "root": _polynomial, "high": _optional_number}),
    "moving body": (
        MovingBody,
        {
            "position": _vector,
            "velocity": _vector,
            "angular_velocity": _vector,
            "inverse_mass": _number,
            "inertia": _optional_columns,
        },
    ),
    "impact": (
        Impact,
        {
            "a": _one("moving body"),
            "b": _one("moving body"),
            "point": _vector,
            "normal": _vector,
            "restitution": _number,
            "friction": _number,
        },
    ),
    "outcome": (Outcome, dict.fromkeys(Outcome.__dataclass_fields__, _vector)),
    "residuals": (
        Residuals,
        {
            **dict.fromkeys(("linear_a", "linear_b", "angular_a", "angular_b"), _vector),
            **dict.fromkeys(("restitution", "pressure", "cone", "energy"), _number),
        },
    ),
    "impact certificate": (
        ImpactCertificate,
        {"impact": _one("impact"), "outcome": _one("outcome"), "residuals": _one("residuals")},
    ),
}
SIMPLE = ("separated", "escape", "near", "common", "core", "inscribed")
CLAIMS = (*SIMPLE, "cover", "part")
SWEEP_CLAIMS = (*CLAIMS, "clear", "meets", "spans", "boxes", "touch")
NAMES = {kind: name for name, (kind, _) in KINDS.items()}
