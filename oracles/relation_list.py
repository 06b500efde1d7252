"""Metamorphic relations: what an engine's answers to two scenes must have in common, whatever the right answers are.

Each is a small function from a batch that the engine has answered to the related scenes; its docstring says why it
exists. The maps are exact, or say how inexact they are, so that two answers that contradict each other need no
reference to be wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from oracles import impact_images
from oracles.claims import past
from oracles.engine import Convention, Status
from oracles.growth import CORNERS, grown, growth
from oracles.images import MIRRORED, QUARTER, TURNED, Axes, moved, refined, refined_surface, rewritten
from oracles.promises import Bounds
from oracles.reference import UNIONS
from oracles.related import GROWN, OTHER, Asked, Carried, Image, image_of
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, Cell
from refimpl.linear import Array, largest, norm, power_of_two, scale
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Ray,
    ShapeError,
    Sphere,
)

Make = Callable[[Asked], Iterator[Image]]

FAR = np.array([4.0, -8.0, 2.0])
ALONG = np.array([0.0, 8.0, 0.0])
"""How far pairs are moved, relative to the power of two above their size; along an axis where slabs must not round."""
LARGER, SMALLER = 2.0**10, 2.0**-10
HEAVIER = 2.0**6
"""By which masses, or velocities, are multiplied."""
GROWTH = -3
"""Power of two, relative to the scene's size, by which proxies are grown."""
ROUND = 2.0**-50
"""Rounding of a point of a ray, relative to the numbers it is the sum of."""


@dataclass(frozen=True)
class Relation:
    """A relation between the answers to two scenes.

    Attributes
    ----------
    changing
        What is done to the scene, as the subject of a sentence.
    family
        What relations that are broken for one reason have in common, as the subject of their symptom.
    contradiction
        What is wrong where the answers are of other queries than the first; empty where it is that they change.
    """

    name: str
    changing: str
    family: str
    contradiction: str
    reason: str
    make: Make

    def symptom(self, aspect: str) -> str:
        """What is wrong: the changed aspect of the answer, or the contradiction."""
        return self.contradiction or f"{self.family} changes the {aspect}"

    @property
    def lost(self) -> str:
        """Symptom of an image that is not answered."""
        return f"{self.family} loses the answer"

    def images(self, asked: Asked) -> Iterator[Image]:
        """Related scenes of a batch; rows for which there is none have infinite errors."""
        try:
            yield from self.make(asked)
        except ShapeError:  # rounding left an image without a set
            return


RELATIONS: dict[str, Relation] = {}

MOTION, SIZE, FORM, ELSEWHERE = "moving both", "scaling both", "writing the same set otherwise", "asking another query"
"""Families: what an engine that keeps distances only roughly breaks all at once."""


def relation(changing: str, family: str = "", contradiction: str = "") -> Callable[[Make], Make]:
    """Register a relation under its function's name; its family is its own, unless it is told."""

    def register(make: Make) -> Make:
        reason = (make.__doc__ or "").strip().splitlines()[0]
        RELATIONS[make.__name__] = Relation(make.__name__, changing, family or changing, contradiction, reason, make)
        return make

    return register


def _exact(shape: Proxy) -> Carried:
    return shape, np.zeros(len(shape))


def _keep(side: int, shape: Proxy) -> Carried:
    del side
    return _exact(shape)


# -- both proxies ----------------------------------------------------------------------------------------------


@relation("swapping A and B")
def swapped(asked: Asked) -> Iterator[Image]:
    """The order of two proxies means nothing; engines write each pair once, and flip frames, normals and witnesses."""
    if asked.motion is not None:
        yield impact_images.exchanged(asked)
    elif asked.cell.query != RAYCAST:
        yield image_of(asked, _keep, sources=(1, 0))


def _by_axes(asked: Asked, axes: Axes) -> Iterator[Image]:
    if asked.motion is not None:
        yield impact_images.by_axes(asked, axes)
    else:
        yield image_of(asked, lambda _, shape: _exact(axes(shape)))


@relation("turning both", MOTION)
def turned(asked: Asked) -> Iterator[Image]:
    """Space has no preferred axes: x becomes z, z y, y x, exactly; code that treats one axis apart is caught."""
    yield from _by_axes(asked, TURNED)


@relation("turning both by 90 degrees", MOTION)
def quarter_turned(asked: Asked) -> Iterator[Image]:
    """A quarter turn about z takes positive coordinates to negative ones, and edges to other edges, exactly."""
    yield from _by_axes(asked, QUARTER)


@relation("mirroring both", MOTION)
def mirrored(asked: Asked) -> Iterator[Image]:
    """A mirror keeps distances but turns every cross product: an isometry that no change of frame hides."""
    yield from _by_axes(asked, MIRRORED)


@relation("moving both", MOTION)
def translated(asked: Asked) -> Iterator[Image]:
    """Only relative positions count: an origin in the wrong frame, or a fixed threshold, shows far from it."""
    size = np.maximum(asked.a.magnitude, asked.b.magnitude)
    step = np.ldexp(1.0, power_of_two(np.maximum(size, np.finfo(float).tiny)))
    if asked.motion is not None:
        yield impact_images.elsewhere(asked, scale(step, FAR))
        return
    slabs = any(isinstance(side, KDOP) or _has_slabs(side) for side in asked.sides)
    offset = scale(step, ALONG if slabs else FAR)

    def carry(_: int, shape: Proxy) -> Carried:
        found = moved(shape, offset)
        return found.shape, found.error

    yield image_of(asked, carry)


def _has_slabs(shape: Proxy) -> bool:
    return isinstance(shape, Composite) and any(isinstance(part, KDOP) or _has_slabs(part) for part in shape.parts)


def _by_size(asked: Asked, factor: float) -> Iterator[Image]:
    if asked.motion is not None:
        yield impact_images.at_another_size(asked, factor)
        return

    def carry(_: int, shape: Proxy) -> Carried:
        image = shape.scaled(factor)
        back = np.all(image.scaled(1 / factor).pack() == shape.pack(), axis=-1)
        return image, np.where(back, 0.0, np.inf)

    yield image_of(asked, carry, factor=factor)


@relation("scaling both up", SIZE)
def scaled_up(asked: Asked) -> Iterator[Image]:
    """No size is special: lengths times 1024 are exact, and absolute thresholds and float32 show."""
    yield from _by_size(asked, LARGER)


@relation("scaling both down", SIZE)
def scaled_down(asked: Asked) -> Iterator[Image]:
    """As scaling up, towards sizes at which absolute thresholds swallow the scene."""
    yield from _by_size(asked, SMALLER)


# -- impacts ---------------------------------------------------------------------------------------------------


@relation("moving along with both bodies")
def moving_along(asked: Asked) -> Iterator[Image]:
    """Galileo's principle: seen from a train, an impact is the same; code that mixes absolute velocities is not."""
    if asked.motion is not None:
        yield impact_images.seen_from_a_train(asked)


@relation("making both bodies heavier")
def heavier(asked: Asked) -> Iterator[Image]:
    """Only the ratio of the masses counts: a unit of mass, or a threshold on one, shows."""
    if asked.motion is not None:
        yield impact_images.heavier(asked, HEAVIER)


@relation("making both bodies quicker")
def quicker(asked: Asked) -> Iterator[Image]:
    """Velocities after an impact are in proportion to those before: thresholds on speed, and clamps, show."""
    if asked.motion is not None:
        yield impact_images.quicker(asked, HEAVIER)


# -- the same sets otherwise -----------------------------------------------------------------------------------


@relation("writing the same sets in other numbers", FORM)
def same_sets(asked: Asked) -> Iterator[Image]:
    """Ends of a capsule, order of vertices and parts, length of a normal or quaternion mean nothing."""
    if asked.motion is not None or all(rewritten(side) is None for side in asked.sides):
        return
    yield image_of(asked, lambda _, shape: _exact(rewritten(shape) or shape))


@relation("refining a mesh")
def finer_mesh(asked: Asked) -> Iterator[Image]:
    """More triangles of the same surface are the same solid: leaks between triangles, and trees of boxes, show."""
    for side, mesh in enumerate(asked.sides):
        found = refined(mesh) if isinstance(mesh, Polyhedron) else None
        if found is None:
            continue
        finer, plan = found

        def carry(
            here: int, shape: Proxy, side: int = side, mesh: Proxy = mesh, finer: Proxy = finer, plan: object = plan
        ) -> Carried:
            if here != side:
                return _exact(shape)
            if shape is mesh:
                return _exact(finer)
            cut = refined_surface(shape, plan) if isinstance(shape, Composite) else None  # type: ignore[arg-type]
            return (shape, np.full(len(shape), np.inf)) if cut is None else _exact(cut)

        yield image_of(asked, carry)


Replace = Callable[[Proxy], Carried | None]
CORNERS_OF_AABB = CORNERS > 0


def _replaced(asked: Asked, instead: Replace) -> Iterator[Image]:
    """One image for each side that has an equal proxy of another type."""
    if asked.motion is not None:
        return
    for side, shape in enumerate(asked.sides):
        made = instead(shape)
        if made is None:
            continue

        def carry(here: int, given: Proxy, side: int = side) -> Carried:
            found = instead(given) if here == side else None
            return found or _exact(given)

        yield image_of(asked, carry).in_table_order()


@relation("writing a sphere as an ellipsoid", FORM)
def as_ellipsoid(asked: Asked) -> Iterator[Image]:
    """A ball is an ellipsoid of equal radii: another algorithm for the same set."""
    yield from _replaced(asked, lambda s: _exact(s.to_ellipsoid()) if isinstance(s, Sphere) else None)


def _capsule(shape: Proxy) -> Carried | None:
    if isinstance(shape, Sphere):
        return _exact(Capsule(shape.center, shape.center, shape.radius))
    return _exact(Capsule(shape.position, shape.position, np.zeros(len(shape)))) if isinstance(shape, Point) else None


@relation("writing a sphere or point as a capsule", FORM)
def as_capsule(asked: Asked) -> Iterator[Image]:
    """A capsule of length 0 is a ball, of radius 0 too a point: axes that vanish divide by zero."""
    yield from _replaced(asked, _capsule)


def _box(shape: Proxy) -> Carried | None:
    if isinstance(shape, Point):
        upright = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(shape), 4))
        return _exact(Box(shape.position, np.zeros((len(shape), 3)), upright))
    return (shape.to_box(), 4 * ROUND * shape.magnitude) if isinstance(shape, AABB) else None


@relation("writing an AABB or point as a box", FORM)
def as_box(asked: Asked) -> Iterator[Image]:
    """An AABB is a box without rotation, a point one without size: flat boxes have faces without area."""
    yield from _replaced(asked, _box)


def _slabs(shape: Proxy) -> Carried | None:
    if not isinstance(shape, AABB):
        return None
    directions = np.broadcast_to(np.eye(3), (len(shape), 3, 3))
    return _exact(KDOP(directions, shape.lower, shape.upper))


@relation("writing an AABB as a k-DOP", FORM)
def as_kdop(asked: Asked) -> Iterator[Image]:
    """An AABB is the k-DOP of three slabs along the axes."""
    yield from _replaced(asked, _slabs)


def _hull(shape: Proxy) -> Carried | None:
    if isinstance(shape, Box):
        corners = CORNERS * shape.half_extents[:, None, :]
        return _exact(ConvexPolyhedron.from_vertices(corners, shape.center, shape.rotation))
    if isinstance(shape, AABB):
        corners = np.where(CORNERS_OF_AABB, shape.upper[:, None, :], shape.lower[:, None, :])
        return _exact(ConvexPolyhedron.from_vertices(corners))
    if isinstance(shape, KDOP):
        normals = np.concatenate([shape.directions, -shape.directions], axis=1)
        offsets = np.concatenate([-shape.upper, shape.lower], axis=1)
        return _exact(ConvexPolyhedron(np.concatenate([normals, offsets[:, :, None]], axis=-1)))
    return None


@relation("writing a box or k-DOP as a hull", FORM)
def as_hull(asked: Asked) -> Iterator[Image]:
    """Boxes are hulls of eight corners, k-DOPs of planes: special cases against the general algorithm."""
    yield from _replaced(asked, _hull)


@relation("writing a proxy as a composite of itself", FORM)
def as_composite(asked: Asked) -> Iterator[Image]:
    """A union of one part is that part: the way through compounds and their frames must change nothing."""
    yield from _replaced(asked, lambda s: None if isinstance(s, UNIONS) or not s.is_solid else _exact(Composite([s])))


# -- larger proxies ---------------------------------------------------------------------------------------------


@relation("growing a proxy", contradiction="growing a proxy moves it away")
def larger(asked: Asked) -> Iterator[Image]:
    """A larger set is nowhere farther: a distance never grows with it, an overlap never ends, no ray comes later."""
    if asked.motion is not None:
        return
    by = np.ldexp(1.0, power_of_two(np.maximum(asked.size, np.finfo(float).tiny)) + GROWTH)
    for side, shape in enumerate(asked.sides):
        if not shape.is_solid:
            continue

        def carry(here: int, given: Proxy, side: int = side) -> Carried:
            return _exact(grown(given, by) if here == side else given)

        least, most = growth(shape, grown(shape, by), by)
        if set(map(type, asked.sides)) & set(UNIONS):
            least, most = np.zeros(len(by)), np.full(len(by), np.inf)  # unions may be grown into each other
        bounds = Bounds(asked.bounds.low - most, asked.bounds.high - least)
        if asked.cell.query == RAYCAST:
            bounds = Bounds(np.full(len(by), -np.inf), asked.bounds.high)
        yield image_of(asked, carry, expected=bounds, alike=GROWN)


# -- what the engine says elsewhere -------------------------------------------------------------------------------


@relation("asking another query", ELSEWHERE, "two queries contradict each other")
def queries(asked: Asked) -> Iterator[Image]:
    """Distance, contacts and overlap are different code in most engines, and speak of the same two sets."""
    others = {DISTANCE: (CONTACTS, BOOLEAN), CONTACTS: (BOOLEAN,)}.get(asked.cell.query, ())
    for query in others:
        yield image_of(asked, _keep, query=query)


def _beside(asked: Asked, side: int, shape: Proxy, error: Array, expected: Bounds) -> Image:
    """A shape of its own against one side of the scene, by distance."""
    other = asked.sides[side]
    cell = Cell(DISTANCE, type(shape), type(other))
    errors = error, np.zeros(len(error))
    return Image(cell, shape, other, (None, side), _keep, errors, expected, alike=OTHER).in_table_order()


@relation(
    "asking for the distance of a ray's segment",
    ELSEWHERE,
    "a ray contradicts the distance of its segment",
)
def segment(asked: Asked) -> Iterator[Image]:
    """A ray up to beyond the proxy is a segment: it hits exactly where that segment's distance is not positive."""
    if not isinstance(asked.a, Ray):
        return
    ray, t = asked.a, asked.answers.t
    reach = past(ray, asked.b)
    reach = np.where((asked.answers.hit == 1) & np.isfinite(t), np.fmax(reach, t), reach)
    with np.errstate(over="ignore", invalid="ignore"):
        end = ray.at(reach)
    usable = largest(end) < 1e150
    end = np.where(usable[:, None], end, ray.origin)
    error = np.where(usable, ROUND * (largest(ray.origin) + largest(end)), np.inf)
    yield _beside(asked, 1, Capsule(ray.origin, end, np.zeros(len(end))), error, asked.bounds)


@relation("asking for the distance of a ray's hit point", ELSEWHERE, "a ray's hit point is off the proxy")
def arrival(asked: Asked) -> Iterator[Image]:
    """Where a ray arrives, the proxy begins: the engine's own distance of that point is 0."""
    if not isinstance(asked.a, Ray):
        return
    ray, answers, room = asked.a, asked.answers, asked.room("value")
    named = (answers.status == Status.ANSWERED) & (answers.hit == 1) & (answers.t >= 0) & (answers.t < 1e150)
    with np.errstate(over="ignore", invalid="ignore"):
        point = ray.at(np.where(named, answers.t, 0.0))
    named &= largest(point) < 1e150
    point = np.where(named[:, None], point, ray.origin)
    error = np.where(named, ROUND * (largest(ray.origin) + largest(point)), np.inf)
    on_surface = (norm(point - ray.origin) > room + error) & (not isinstance(asked.b, UNIONS))
    yield _beside(asked, 1, Point(point), error, Bounds(np.where(on_surface, -room, -np.inf), room))


@relation("asking for the distance of a witness", ELSEWHERE, "a witness is off its proxy by its own distance")
def witnesses(asked: Asked) -> Iterator[Image]:
    """Witness points belong to their proxies: the engine's own distance of each is not positive."""
    answers = asked.answers
    if asked.motion is not None or asked.cell.query not in (DISTANCE, CONTACTS):
        return
    for side, (shape, witness) in enumerate(zip(asked.sides, (answers.on_a, answers.on_b), strict=True)):
        said = (answers.status == Status.ANSWERED) & (largest(witness) < 1e150)
        if isinstance(shape, Point) or not said.any():
            continue
        point = Point(np.where(said[:, None], witness, 0.0))
        nothing = np.full(len(asked), -np.inf)
        error = np.where(said, 0.0, np.inf)
        yield _beside(asked, side, point, error, Bounds(nothing, asked.room("witness")))


@relation("moving B back along the normal", contradiction="moved by its normal and distance, the pair does not touch")
def normals(asked: Asked) -> Iterator[Image]:
    """A normal with its distance is a promise: B moved back by them touches A, by the engine's own distance."""
    answers, query = asked.answers, asked.cell.query
    conventions = asked.engine.conventions(query, asked.cell.type_a, asked.cell.type_b)
    if asked.motion is not None or query not in (DISTANCE, CONTACTS) or Convention.OF_ONE_TRIANGLE in conventions:
        return
    if HalfSpace is asked.cell.type_a is asked.cell.type_b:
        return  # their distance is no length: at the least tilt they overlap without end
    said = (answers.status == Status.ANSWERED) & (np.abs(answers.distance) < 1e150)
    said &= np.isfinite(answers.normal).all(axis=-1)
    if any(isinstance(side, UNIONS) for side in asked.sides):
        said &= answers.distance > 0
    if not said.any():
        return
    move = np.where(said[:, None], -scale(np.where(said, answers.distance, 0.0), answers.normal), 0.0)
    first_moves = isinstance(asked.b, KDOP)
    room = asked.room("value")

    def carry(side: int, shape: Proxy) -> Carried:
        if side == (0 if first_moves else 1):
            found = moved(shape, -move if first_moves else move)
            return found.shape, np.where(said, found.error + ROUND * largest(move), np.inf)
        return _exact(shape)

    query = DISTANCE if asked.engine.support(DISTANCE, asked.cell.type_a, asked.cell.type_b) else query
    yield image_of(asked, carry, query=query, expected=Bounds(-room, room), alike=OTHER)
