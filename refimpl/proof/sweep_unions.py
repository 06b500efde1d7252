"""Claims about the first contact of unions in translation: of the first pair of atoms, and trees of planes until then.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction

import numpy as np

from refimpl.atoms import groups, leaves
from refimpl.motions import REST, Translation
from refimpl.pairs import TABLE
from refimpl.proof.atoms import Atom, Directions, Unproven, atoms_of
from refimpl.proof.checker import sides_of
from refimpl.proof.claims import Separated
from refimpl.proof.convex import plain
from refimpl.proof.points import Vector, doubles, round_down
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.sweep_casts import Contact, Undecided
from refimpl.proof.sweep_search import first_contact, first_proven, place_of, separated
from refimpl.proof.sweeps import Clear, Meets, SweepClaim, clear
from refimpl.proof.union_search import places_of
from refimpl.proof.vectors import Number
from refimpl.shapes import Proxy
from refimpl.sweeps.translations import advance, earliest
from refimpl.sweeps.unions import in_turn

CLEAR = 1e-9  # relative to the scene: atoms so far from each other all the way need one direction only
FIRST = 1e-9  # so little later in doubles than the first contact, a pair of atoms may meet first
PAIRS, MANY = 60, 1000  # of atoms, that are looked at exactly


def union_sweep(a: Proxy, b: Proxy, way: Vector) -> tuple[SweepClaim, ...]:
    """Make claims about unions that are apart at the start, of which `b` moves along `way`."""
    found = _first_contacts(a, b, way, False) or _first_contacts(a, b, way, True)
    size = max(float(a.magnitude), float(b.magnitude), *map(abs, doubles(way)))
    if not found:
        return tuple(_clear(a, b, way, [None], size))
    first, atom, other = min(found, key=lambda item: item[0].high)
    low = min(contact.low for contact, _, _ in found)
    ends = place_of(atom.shape, *first.ends[0]), place_of(other.shape, *first.ends[1])
    early = round_down(low)
    times = [time for time in (math.nextafter(early, 0.0), low, low * (1 - Fraction(1, 1 << 60))) if time > 0]
    return (*_clear(a, b, way, times, size), Meets(first.high, *ends, atom.number, other.number))


def _first_contacts(a: Proxy, b: Proxy, way: Vector, every: bool) -> list[tuple[Contact, Atom, Atom]]:
    """Contacts of atoms, also the first; of `every` pair that meets in doubles, as the first may only seem to."""
    of_a, of_b = atoms_of(a), atoms_of(b)
    found: list[tuple[Contact, Atom, Atom]] = []
    for t, i, j in _pairs(a, b, doubles(way), every):
        if found and t > min(contact.high for contact, _, _ in found) + FIRST:
            break
        with suppress(Undecided):
            contact = first_contact(of_a[i].shape, of_b[j].shape, way)
            if isinstance(contact, Contact) and contact.high <= 1:
                found.append((contact, of_a[i], of_b[j]))
    return found


def _pairs(a: Proxy, b: Proxy, way: Vector, every: bool) -> list[tuple[float, int, int]]:
    """Atoms that meet in doubles, or nearly so, by their times; only those that may be the first, or `every` one."""
    found: list[tuple[float, int, int]] = []
    best = math.inf
    motion = Translation(np.array(way, dtype=np.float64))
    for one in groups(leaves(a), surfaces=True):
        for other in groups(leaves(b), surfaces=True):
            for early, i, j in in_turn(one, other, REST, motion, earliest):
                if early > best + FIRST:
                    continue
                rows = np.broadcast_to(motion.vector, (len(i), 3))
                if (type(one.proxies), type(other.proxies)) in TABLE:
                    hit = advance(one.proxies[i], other.proxies[j], rows)
                else:
                    hit = advance(other.proxies[j], one.proxies[i], -rows)
                t = np.minimum(hit.t, hit.t_lower)
                best = math.inf if every else min(best, float(np.min(hit.t)))
                near = np.flatnonzero(t <= min(best + FIRST, 1 + FIRST))
                found += zip(
                    t[near].tolist(), one.numbers[i[near]].tolist(), other.numbers[j[near]].tolist(), strict=True
                )
    return [pair for pair in sorted(found) if pair[0] <= best + FIRST][: MANY if every else PAIRS]


class _Sweeping(Directions):
    """Builds a tree of directions that keep atoms apart until a time."""

    def __init__(self, way: Vector, until: Number | None, least: float) -> None:
        self.until, self.exactly = until, way
        share = 1.0 if until is None else float(until)
        super().__init__(least, [], share * np.array(doubles(way)))

    def _exactly(self, a: Atom, b: Atom, normal: Vector) -> Vector:
        candidates: list[Vector] = [normal]
        try:
            found = first_contact(a.shape, b.shape, self.exactly).normal
            candidates = [plain(found), found]
        except Undecided:
            pass
        spans = [Clear(separated(a.shape, b.shape, n), self.until) for n in candidates]
        for span in first_proven(a.shape, b.shape, self.exactly, spans):
            assert isinstance(span.tree, Separated)
            return span.tree.n
        raise Unproven


def _clear(a: Proxy, b: Proxy, way: Vector, times: Iterable[Number | None], size: float) -> Iterator[Clear]:
    """A span without contact that ends at the first of some times for which it can be shown."""
    with sides_of(a, b) as sides:
        for time in times:
            try:
                tree = _Sweeping(way, time, CLEAR * size).build(atoms_of(a), atoms_of(b))
                span = Clear(tree, time, (places_of(a), places_of(b)))
                clear(span, sides, way, Fraction(0))
            except (Unproven, InvalidCertificate):
                continue
            yield span
            return
