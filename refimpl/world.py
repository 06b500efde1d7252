"""The lecture's pipeline: which of many bodies collide, found in two phases, and answered.

    for A, B in broad phase:                          # boxes that overlap
        if not intersect(A.volume, B.volume):         # early reject
            continue
        data = collide(A.collider, B.collider)        # collider
        if data.hit:
            respond(data, A, B)                       # response

`World` does that for all pairs at once, stage by stage, and counts how many pairs each stage leaves to the next.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from refimpl.bodies import Body, State
from refimpl.broadphase import BroadPhase, ColumnSweep, Numbered
from refimpl.fields import ShapeError
from refimpl.impacts.reading import at_least_zero, real, share
from refimpl.impacts.response import respond
from refimpl.linear import Bools
from refimpl.queries import collide, intersect
from refimpl.results import CollisionData
from refimpl.signs import Indices
from refimpl.volumes import placed, placed_volume

BROAD_PHASE, EARLY_REJECT, COLLIDER, RESPONSE = STAGES = ("broad phase", "early reject", "collider", "response")


@dataclass
class Stage:
    """What one stage of the pipeline did so far: pairs that it was asked, pairs that it left over, and seconds."""

    asked: int = 0
    left: int = 0
    seconds: float = 0.0

    @property
    def rejected(self) -> int:
        """Pairs that went no further."""
        return self.asked - self.left


@dataclass(frozen=True)
class Contacts:
    """Bodies that collide.

    Attributes
    ----------
    pairs : (m, 2) int
        Numbers of bodies, i < j, sorted.
    data : CollisionData with one batch axis
        Of the bodies' colliders, in that order.
    """

    pairs: Indices
    data: CollisionData


class World:
    """Bodies, static and dynamic, whose collisions are found and answered.

    Parameters
    ----------
    bodies : sequence of Body
    restitution, friction : float
        Of all impacts.
    gravity : (3,), length / time²
    broad_phase : BroadPhase
        Any of `refimpl.broadphase`, empty; columns of a grid, sorted along the third axis, if none is given.
    early_reject : bool
        Whether bounding volumes are tested before colliders.

    Attributes
    ----------
    state : State
    colliders, volumes : Numbered
        Where the bodies are now.
    stages : dict of str to Stage
        What happened to the pairs, by the names in `STAGES`, until `reset_counters` is called.

    Raises
    ------
    ShapeError
        For what is no body, and numbers that no impact has.

    Notes
    -----
    Two static bodies never collide; one that has a velocity moves with it, whatever it meets. The box of a body without
    end (a half-space) is infinite.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        *,
        restitution: float = 0.5,
        friction: float = 0.0,
        gravity: Any = (0.0, 0.0, 0.0),
        broad_phase: BroadPhase | None = None,
        early_reject: bool = True,
    ) -> None:
        self.bodies = tuple(bodies)
        for number, body in enumerate(self.bodies):
            if not isinstance(body, Body):
                raise ShapeError(f"bodies[{number}]: expected a Body, got {type(body).__name__}: Body(proxy) makes one")
        share("restitution", restitution)
        at_least_zero("friction", friction)
        self.restitution, self.friction, self.gravity = restitution, friction, real("gravity", gravity, 3)
        self.early_reject = early_reject
        self.state = State.of(self.bodies)
        self._colliders = Numbered.by_form([body.collider for body in bodies])
        self._volumes = Numbered.by_form([body.volume for body in bodies])
        self._broad = ColumnSweep() if broad_phase is None else broad_phase
        self.reset_counters()
        self._place()
        self._broad.build(self._lower, self._upper, ~self.state.movable)

    def reset_counters(self) -> None:
        """Count from 0 again."""
        self.stages = {name: Stage() for name in STAGES}

    # -- the pipeline ----------------------------------------------------------------------------------------

    def step(self, dt: float) -> Contacts:
        """Let time pass, then find the collisions and answer them; gives what was found.

        One collision is answered after the other, as in the lecture's loop: where a body has several, the later ones
        are looked at anew, with the body where the earlier ones left it.
        """
        self.state.advance(float(at_least_zero("dt", dt)), self.gravity)
        self._place()
        self._moved()
        found = self.detect()
        self.respond(found)
        return found

    def detect(self) -> Contacts:
        """Find all bodies that collide where they are now."""
        pairs = self.candidates()
        if self.early_reject:
            pairs = pairs[self.volumes_meet(pairs)]
        data = self.collide(pairs)
        hit = np.asarray(data.hit, dtype=bool)
        return Contacts(pairs[hit], data[hit])

    def candidates(self) -> Indices:
        """Broad phase: pairs of bodies whose boxes overlap; one of the two at least can move."""
        with self._counted(BROAD_PHASE, self._possible()) as stage:
            pairs = self._broad.pairs()
            stage.left += len(pairs)
        return pairs

    def volumes_meet(self, pairs: Indices) -> Bools:
        """Early reject: which pairs (m, 2) of bodies have bounding volumes that intersect."""
        meet = np.zeros(len(pairs), dtype=bool)
        with self._counted(EARLY_REJECT, len(pairs)) as stage:
            for which, a, b in self.volumes.by_types(pairs):
                meet[which] = intersect(a, b)
            stage.left += int(np.count_nonzero(meet))
        return meet

    def collide(self, pairs: Indices) -> CollisionData:
        """Collider: collision data of pairs (m, 2) of bodies."""
        found = _nothing(len(pairs))
        with self._counted(COLLIDER, len(pairs)) as stage:
            for which, a, b in self.colliders.by_types(pairs):
                masses = self.state.inverse_mass[pairs[which]]
                data = collide(a, b, masses[:, 0], masses[:, 1])
                for spec in fields(CollisionData):
                    getattr(found, spec.name)[which] = getattr(data, spec.name)
            stage.left += int(np.count_nonzero(found.hit))
        return found

    def respond(self, contacts: Contacts) -> None:
        """Response: move the bodies of all contacts apart, and let those that approach bounce.

        Contacts that share no movable body do not see each other, and are answered together.
        """
        for number, which in enumerate(rounds(contacts.pairs, self.state.movable)):
            pairs = contacts.pairs[which]
            data = contacts.data[which] if number == 0 else self.collide(pairs)
            with self._counted(RESPONSE, len(pairs)) as stage:
                i, j = pairs.T
                after = respond(data, self.state.rigid(i), self.state.rigid(j), self.restitution, self.friction)
                self.state.put(i, after.a)
                self.state.put(j, after.b)
                stage.left += int(np.count_nonzero(after.met))
            self._place()
        if len(contacts.pairs):
            self._moved()

    # -- what it needs ---------------------------------------------------------------------------------------

    def _possible(self) -> int:
        """Pairs that brute force would look at: all but those of two static bodies."""
        every, static = len(self.bodies), int(np.count_nonzero(~self.state.movable))
        return every * (every - 1) // 2 - static * (static - 1) // 2

    def _moved(self) -> None:
        """Tell the broad phase where the bodies are that can have moved: a static one moves if it has a velocity."""
        told = np.any((self.state.velocity != 0) | (self.state.spin != 0), axis=1)
        ids = np.flatnonzero(self.state.movable | told)
        if len(ids):
            self._broad.update(ids, self._lower[ids], self._upper[ids])

    def _place(self) -> None:
        """Put colliders, their boxes and volumes where the bodies are."""
        position, rotation = self.state.position, self.state.rotation
        self.colliders = self._colliders.mapped(lambda shapes, ids: placed(shapes, rotation[ids], position[ids]))
        self._lower, self._upper = self.colliders.boxes()
        self.volumes = self._volumes.mapped(
            lambda shapes, ids: placed_volume(shapes, rotation[ids], position[ids], self._lower[ids], self._upper[ids])
        )

    @contextmanager
    def _counted(self, name: str, asked: int) -> Iterator[Stage]:
        """Note how long a stage takes, and how many pairs it is asked."""
        stage, start = self.stages[name], time.perf_counter()
        stage.asked += asked
        yield stage
        stage.seconds += time.perf_counter() - start


def rounds(pairs: Indices, movable: Bools) -> list[Indices]:
    """Put pairs (m, 2) into rounds, none of which has two pairs with a movable body in common.

    Each pair comes after all pairs before it that share a movable body with it: one round after the other does what
    one pair after the other would do.

    Returns
    -------
    list of (k,) int
        Rows of `pairs`.
    """
    busy = [0] * len(movable)
    found: list[list[int]] = []
    for row, (i, j) in enumerate(pairs.tolist()):
        turn = max(busy[i], busy[j])
        for body in (i, j):
            if movable[body]:
                busy[body] = turn + 1
        if turn == len(found):
            found.append([])
        found[turn].append(row)
    return [np.array(rows) for rows in found]


def _nothing(count: int) -> CollisionData:
    """Collision data of so many pairs, to be filled in."""
    numbers, vectors = (count,), (count, 3)
    shapes = (numbers, vectors, numbers, numbers, vectors, vectors, vectors, vectors)
    return CollisionData(np.zeros(count, dtype=bool), *(np.zeros(shape) for shape in shapes[1:]))
