"""Wrong contacts."""

from __future__ import annotations

from oracles.claims import APART, FALSE, LENGTHY, LONG, MISSED, OFF_SHAPE, SHORT, STUCK, TOGETHER
from oracles.engine import COLUMNS, NAN, AnswerRow
from oracles.planted.mutant import Planted, wrong
from oracles.planted.shapes import Ball, Brick, Gap, Plane, Rod
from oracles.planted.vectors import UNITS, Vec, along, dot, sub, times
from oracles.scene import CONTACTS


@wrong(CONTACTS, "Sphere–Sphere", STUCK)
class ContactFlipped(Planted):
    """The contact normal points from B to A."""

    def contact(self, gap: Gap) -> AnswerRow:
        return super().contact(gap._replace(normal=times(-1.0, gap.normal)))


@wrong(CONTACTS, "Box–Box", SHORT)
class SecondBestAxis(Planted):
    """The depth of the wrong axis: the second best."""

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        gap = super().overlapping(a, b, separation, normal)
        middle = sub(b.center, a.center)
        gaps = sorted(abs(dot(middle, n)) - (a.reach(n) + b.reach(n)) for n in self.axes_to_try(a, b))
        return gap._replace(distance=gaps[-2])


@wrong(CONTACTS, "Sphere–Box", TOGETHER, OFF_SHAPE)
class PointOnWrongShape(Planted):
    """The contact point on the box is told twice, also as the one on the ball."""

    def contact(self, gap: Gap) -> AnswerRow:
        return super().contact(gap._replace(on_a=gap.on_b))


@wrong(CONTACTS, "Sphere–HalfSpace", MISSED)
class DroppedAtTouching(Planted):
    """A contact is dropped when it is less than a millionth deep."""

    def hits(self, gap: Gap) -> bool:
        return gap.distance <= -1e-6


@wrong(CONTACTS, "Capsule–Capsule", LONG)
class DepthPositive(Planted):
    """A sign: the depth is told as a positive distance."""

    def contact(self, gap: Gap) -> AnswerRow:
        row = list(super().contact(gap))
        row[COLUMNS["distance"]] = [-gap.distance] if self.hits(gap) else [NAN]
        return row


@wrong(CONTACTS, "Sphere–Capsule", FALSE)
class ContactBeforeTouching(Planted):
    """A margin of a hundredth counts as contact."""

    def hits(self, gap: Gap) -> bool:
        return gap.distance <= 0.01


@wrong(CONTACTS, "Sphere–AABB", LENGTHY)
class NormalTooLong(Planted):
    """The normal is not brought to length 1."""

    def contact(self, gap: Gap) -> AnswerRow:
        return super().contact(gap._replace(normal=times(1.01, gap.normal)))


@wrong(CONTACTS, "Point–Box", OFF_SHAPE)
class PointInOwnFrame(Planted):
    """A wrong frame: the contact point that is the point itself is told in the box's axes."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(on_a=b.into(gap.on_a))


@wrong(CONTACTS, "Sphere–Box", STUCK)
class FaceNormalNotTurned(Planted):
    """A wrong frame: of a centre inside, the face's normal is not turned into the world."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        if gap.distance > -a.radius:
            return gap
        n = gap.normal
        return gap._replace(normal=(dot(n, b.axes[0]), dot(n, b.axes[1]), dot(n, b.axes[2])))


@wrong(CONTACTS, "Capsule–AABB", LONG)
class RadiusForgotten(Planted):
    """A dropped term: where the segment itself is inside, the radius is not added to the depth."""

    def rod_brick(self, a: Rod, b: Brick) -> Gap:
        gap = super().rod_brick(a, b)
        return gap._replace(distance=gap.distance + a.radius) if gap.distance < -a.radius else gap


@wrong(CONTACTS, "Sphere–AABB", LONG)
class DepthClamped(Planted):
    """A wrong clamp: no depth is more than the ball's radius."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(distance=max(gap.distance, -a.radius))


@wrong(CONTACTS, "AABB–AABB", LONG)
class SharedWidth(Planted):
    """The depth is the width of the intersection, which is too little where one box holds the other."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        gap = super().upright_upright(a, b)
        if gap.distance > 0:
            return gap
        widths = [
            min(x + h, y + g) - max(x - h, y - g) for x, h, y, g in zip(a.center, a.half, b.center, b.half, strict=True)
        ]
        return gap._replace(distance=max(gap.distance, -min(widths)))


@wrong(CONTACTS, "Box–Box", SHORT, FALSE)
class FacesOnly(Planted):
    """A dropped case: contacts of two edges are taken for contacts of a face."""

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        return []


@wrong(CONTACTS, "HalfSpace–Box", TOGETHER, OFF_SHAPE)
class PointHalfway(Planted):
    """Both contact points are the one halfway between them."""

    def contact(self, gap: Gap) -> AnswerRow:
        middle = times(0.5, (gap.on_a[0] + gap.on_b[0], gap.on_a[1] + gap.on_b[1], gap.on_a[2] + gap.on_b[2]))
        return super().contact(gap._replace(on_a=middle, on_b=middle))


@wrong(CONTACTS, "Capsule–HalfSpace", MISSED, LONG)
class UpperEnd(Planted):
    """The wrong end of the rod: the upper one decides whether there is a contact."""

    def lower_end(self, rod: Rod, plane: Plane) -> Vec:
        return max((rod.p, rod.q), key=plane.height)


@wrong(CONTACTS, "AABB–Box", STUCK)
class AxisOfWorld(Planted):
    """The normal is the world's axis that is nearest to the true one."""

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        axis = max(range(3), key=lambda i: abs(normal[i]))
        snapped = times(1.0 if normal[axis] > 0 else -1.0, UNITS[axis])
        return super().overlapping(a, b, separation, normal)._replace(normal=snapped)


@wrong(CONTACTS, "Capsule–Capsule", APART, TOGETHER)
class PointOnSegment(Planted):
    """The contact point on A lies on its segment, not on its surface."""

    def rod_rod(self, a: Rod, b: Rod) -> Gap:
        gap = super().rod_rod(a, b)
        return gap._replace(on_a=along(gap.on_a, -a.radius, gap.normal))
