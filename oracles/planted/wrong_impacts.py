"""Wrong impacts."""

from __future__ import annotations

from oracles import impact_laws as law
from oracles.engine import AnswerRow, Row
from oracles.planted.impacts import Body, Contact, solved
from oracles.planted.mutant import Planted, wrong
from oracles.planted.vectors import UNITS, Axes, Vec, along, cross, length, times
from oracles.scene import IMPACT


@wrong(IMPACT, "Sphere–Sphere", law.FAST)
class RestitutionTwice(Planted):
    """Restitution is applied twice."""

    def bounce(self, restitution: float, speed: float) -> float:
        return 2 * restitution


@wrong(IMPACT, "Sphere–Capsule", law.SLOW)
class RestitutionIgnored(Planted):
    """Every impact is inelastic."""

    def bounce(self, restitution: float, speed: float) -> float:
        return 0.0


@wrong(IMPACT, "Sphere–Box", law.SLOW)
class SlowDoesNotBounce(Planted):
    """An absolute threshold: below a tenth of a unit of speed nothing bounces."""

    def bounce(self, restitution: float, speed: float) -> float:
        return restitution if speed > 0.1 else 0.0


@wrong(IMPACT, "Sphere–HalfSpace", law.CONE)
class ConeTwice(Planted):
    """The friction cone is twice as wide."""

    def share(self, push: float, rest: Vec, n: Vec, friction: float) -> float:
        return super().share(push, rest, n, 2 * friction)


@wrong(IMPACT, "Capsule–HalfSpace", law.SLIPPERY)
class FrictionIgnored(Planted):
    """There is no friction."""

    def share(self, push: float, rest: Vec, n: Vec, friction: float) -> float:
        return 0.0


@wrong(IMPACT, "Sphere–HalfSpace", law.CONE)
class AlwaysSticks(Planted):
    """Friction always ends the sliding, whatever its coefficient."""

    def share(self, push: float, rest: Vec, n: Vec, friction: float) -> float:
        return 1.0


@wrong(IMPACT, "Sphere–Sphere", law.FAST)
class MassOfOne(Planted):
    """The reduced mass is that of B alone."""

    def give(self, a: Body, b: Body, point: Vec) -> Axes:
        x, y, z = (self.yields(b, point, u) for u in UNITS)
        return (x, y, z) if b.inverse_mass > 0 else super().give(a, b, point)


@wrong(IMPACT, "Sphere–Box", law.ANGULAR)
class InertiaNotTurned(Planted):
    """The inertia is used without its products, as if the box stood along the axes."""

    def spun(self, body: Body, arm: Vec, push: Vec) -> Vec:
        (xx, _, _), (_, yy, _), (_, _, zz) = body.inertia
        return solved(((xx, 0.0, 0.0), (0.0, yy, 0.0), (0.0, 0.0, zz)), cross(arm, push))


@wrong(IMPACT, "Sphere–Capsule", law.ANGULAR)
class SpinForgotten(Planted):
    """The angular part is dropped: no impulse changes a spin."""

    def pushed(self, body: Body, point: Vec, push: Vec) -> Body:
        return super().pushed(body, point, push)._replace(spin=body.spin)


@wrong(IMPACT, "HalfSpace–Box", law.FIXED)
class ImmovableTurns(Planted):
    """What cannot be moved is turned all the same."""

    def is_fixed(self, body: Body) -> bool:
        return False


@wrong(IMPACT, "Sphere–Sphere", law.DISTURBED)
class PartingPulled(Planted):
    """Bodies that part are pulled together: the sign of their speed is not looked at."""

    def closes(self, speed: float, approach: Vec) -> bool:
        return True


@wrong(IMPACT, "Sphere–Capsule", law.MISSED)
class GrazingIgnored(Planted):
    """What touches at less than a thousandth of its speed is said not to meet."""

    def closes(self, speed: float, approach: Vec) -> bool:
        return speed < -1e-3 * length(approach)


@wrong(IMPACT, "Sphere–HalfSpace", law.ENERGY, law.SLIPPERY)
class FrictionReversed(Planted):
    """A sign: friction drives the sliding instead of slowing it."""

    def share(self, push: float, rest: Vec, n: Vec, friction: float) -> float:
        return -super().share(push, rest, n, friction)


@wrong(IMPACT, "Sphere–Sphere", law.MOMENTUM)
class MassesSwapped(Planted):
    """Each body gets the impulse with the other's mass."""

    def meet(self, a: Body, b: Body, contact: Contact) -> tuple[Body, Body]:
        after_a, after_b = super().meet(a, b, contact)
        if a.inverse_mass == 0 or b.inverse_mass == 0:
            return after_a, after_b
        ratio = b.inverse_mass / a.inverse_mass
        return _scaled(a, after_a, ratio), _scaled(b, after_b, 1 / ratio)


@wrong(IMPACT, "Sphere–Capsule", law.MOMENTUM, law.SLOW)
class OnlyOnePushed(Planted):
    """The counter-impulse is dropped where both can move: only B is pushed."""

    def meet(self, a: Body, b: Body, contact: Contact) -> tuple[Body, Body]:
        after_a, after_b = super().meet(a, b, contact)
        return (a, after_b) if b.inverse_mass > 0 else (after_a, after_b)


@wrong(IMPACT, "Capsule–HalfSpace", law.ANGULAR)
class LeverTooLong(Planted):
    """The lever of the spin is half as long again as it should be."""

    def pushed(self, body: Body, point: Vec, push: Vec) -> Body:
        after = super().pushed(body, point, push)
        spin = tuple(old + 1.5 * (new - old) for old, new in zip(body.spin, after.spin, strict=True))
        return after._replace(spin=(spin[0], spin[1], spin[2]))


@wrong(IMPACT, "Capsule–HalfSpace", law.PULLED, law.SLOW)
class NormalOfImpactFlipped(Planted):
    """A sign: the impulse pulls the bodies at each other."""

    def impulse(self, a: Body, b: Body, contact: Contact, approach: Vec) -> Vec:
        return times(-1.0, super().impulse(a, b, contact, approach))


@wrong(IMPACT, "Sphere–Box", law.MOMENTUM, law.PULLED)
class SpeedClamped(Planted):
    """Wrong only when fast: no body moves faster than 100 after an impact."""

    def pushed(self, body: Body, point: Vec, push: Vec) -> Body:
        after = super().pushed(body, point, push)
        speed = length(after.velocity)
        return after if speed <= 100 else after._replace(velocity=times(100 / speed, after.velocity))


@wrong(IMPACT, "HalfSpace–Box", law.FAST, law.SLOW)
class ImpactNormalNotNormalised(Planted):
    """The normal of the contact is used as it is, whatever its length."""

    def impact(self, row: Row) -> AnswerRow:
        n = row[-5:-2]
        self.stretch = length((n[0], n[1], n[2]))
        return super().impact(row)

    def impulse(self, a: Body, b: Body, contact: Contact, approach: Vec) -> Vec:
        return times(self.stretch, super().impulse(a, b, contact, approach))


@wrong(IMPACT, "Sphere–HalfSpace", law.MISSED)
class LightBodyIgnored(Planted):
    """Wrong only for masses under a hundredth: such a ball meets nothing."""

    def meet(self, a: Body, b: Body, contact: Contact) -> tuple[Body, Body]:
        return (a, b) if max(a.inverse_mass, b.inverse_mass) > 100 else super().meet(a, b, contact)


@wrong(IMPACT, "Sphere–Sphere", law.FAST)
class AlwaysElastic(Planted):
    """Every impact is elastic."""

    def bounce(self, restitution: float, speed: float) -> float:
        return 1.0


@wrong(IMPACT, "Sphere–Sphere", law.MISSED)
class NothingHappens(Planted):
    """The velocities are those before the impact."""

    def pushed(self, body: Body, point: Vec, push: Vec) -> Body:
        return body


@wrong(IMPACT, "Sphere–Box", law.FIXED)
class ImmovableGivesWay(Planted):
    """What cannot be moved is taken for as heavy as the other body."""

    def meet(self, a: Body, b: Body, contact: Contact) -> tuple[Body, Body]:
        if a.inverse_mass == 0:
            a = a._replace(inverse_mass=b.inverse_mass, inertia=b.inertia)
        if b.inverse_mass == 0:
            b = b._replace(inverse_mass=a.inverse_mass, inertia=a.inertia)
        return super().meet(a, b, contact)


def _scaled(before: Body, after: Body, ratio: float) -> Body:
    """A body whose velocity has changed by a multiple."""
    change = along(after.velocity, -1.0, before.velocity)
    return after._replace(velocity=along(before.velocity, ratio, change))
