"""Certificates of moving triangles: what they prove, that false ones are refused, and that JSON keeps them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.triangles import TouchCertificate, check_vertex_face
from refimpl.proof.wire import touch_from_json, touch_to_json
from refimpl.sweeps.triangles import vertex_face
from tests.moving import FAMILIES
from tests.test_moving_triangles import CHECK, DECIDE, KINDS, KNOWN

F = Fraction


def tampered(rng: np.random.Generator, given: TouchCertificate) -> TouchCertificate:
    """A certificate changed in one place."""
    cover = list(given.cover)
    i = int(rng.integers(len(cover))) if cover else 0
    which = int(rng.integers(7))
    if which == 0 and cover:
        cover[i] = (cover[i][0], int(rng.integers(10)))
    elif which == 1 and cover:
        cover[i] = ((cover[i][0] + 1) / 2, cover[i][1])
    elif which == 2:
        del cover[i : i + 1]
    elif which == 3:
        return replace(given, cover=(*cover, (F(1), 0)), root=None, high=None)
    elif which == 4 and given.root is not None:
        return replace(given, root=tuple(c + int(d) for c, d in zip(given.root, rng.integers(-1, 2, 4), strict=False)))
    elif which == 5:
        return replace(given, root=(-1, int(rng.integers(1, 4))), high=F(1))
    else:
        low = cover[-1][0] if cover else F(0)
        return replace(given, high=low + (1 - low) * F(int(rng.integers(1, 9)), 8), root=given.root or (-1, 1))
    return replace(given, cover=tuple(cover))


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_tampered_certificate_proves_is_true_all_the_same(kind: str) -> None:
    rng = np.random.default_rng(4)
    refused = 0
    for draw in list(FAMILIES.values()) * 12:
        query = draw(rng)
        found = DECIDE[kind](*query)
        try:
            low, high = CHECK[kind](tampered(rng, found.certificate), *query)
        except InvalidCertificate:
            refused += 1
            continue
        if low == math.inf:
            assert not found.hit
        else:
            assert found.hit
            assert low <= found.high  # type: ignore[operator]
            assert found.low <= high  # type: ignore[operator]
    assert refused > 66


HIT = vertex_face(*KNOWN["straight through"][1:3])
MISS = vertex_face(*KNOWN["beside it by one ulp"][1:3])
REFUSED: dict[str, tuple[str, Any, str]] = {
    "another's hit": ("beside it by one ulp", HIT.certificate, "may hold|may not hold"),
    "another's miss": ("through an edge", MISS.certificate, "may not hold"),
    "no cover": ("straight through", TouchCertificate(()), "ends at"),
    "time back": ("straight through", replace(HIT.certificate, cover=((F(1, 4), 0), (F(1, 8), 0))), "increase"),
    "beyond the end": ("beside it by one ulp", TouchCertificate(((F(2), 0),)), "increase"),
    "no such exclusion": ("straight through", replace(HIT.certificate, cover=((F(1, 4), 13),)), "no exclusion"),
    "a negative exclusion": ("straight through", replace(HIT.certificate, cover=((F(1, 4), -13),)), "no exclusion"),
    "a constant": ("straight through", replace(HIT.certificate, root=(0, 0)), "constant"),
    "no change of sign": ("straight through", replace(HIT.certificate, root=(1, 1)), "change"),
    "a root before the cover's end": ("straight through", replace(HIT.certificate, high=F(1, 4)), "from the end"),
    "not whole": ("straight through", replace(HIT.certificate, root=(-1.0, 3.0)), "whole"),
    "high without a root": ("beside it by one ulp", replace(MISS.certificate, high=F(1)), "without a root"),
    "not a certificate": ("straight through", HIT, "not a certificate"),
    "a huge number": ("straight through", replace(HIT.certificate, high=F(1, 1 << 20000)), "bits"),
    "too long": ("straight through", TouchCertificate(tuple((F(i, 70000), 0) for i in range(1, 70001))), "items"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_false_certificate_is_refused(what: str) -> None:
    name, certificate, text = REFUSED[what]
    _, start, end, _ = KNOWN[name]
    with pytest.raises(InvalidCertificate, match=text):
        check_vertex_face(certificate, start, end)


@pytest.mark.parametrize("kind", KINDS)
def test_a_certificate_proves_the_same_after_json(kind: str) -> None:
    rng = np.random.default_rng(9)
    for draw in FAMILIES.values():
        certificate = DECIDE[kind](*draw(rng)).certificate
        assert touch_from_json(json.loads(json.dumps(touch_to_json(certificate)))) == certificate


@pytest.mark.parametrize(
    ("field", "value"),
    [("cover", [[1]]), ("cover", [["x", 0]]), ("root", ["1/2", 1]), ("root", 3), ("high", "inf"), ("other", 1)],
)
def test_json_of_another_form_is_refused(field: str, value: Any) -> None:
    with pytest.raises(InvalidCertificate):
        touch_from_json(touch_to_json(HIT.certificate) | {field: value})
