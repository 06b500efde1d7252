"""Laws of impacts, in exact rationals and with equality; each is shown to fail on a wrong formula."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from refimpl.impacts import (
    RigidBody,
    approach,
    elastic_on_line,
    impact_of_bodies,
    impact_of_particles,
    impact_on_line,
    inelastic_on_line,
    join_bodies,
    merge_particles,
    split,
)
from refimpl.impacts.laws import certify
from refimpl.proof.impacts import Residuals
from tests.impact_scenes import HEAVY, MASSES, NORMALS, NUMBERS, RUBS, SHARES, VECTORS, Scene, scenes
from tests.wrong_impact_formulas import (
    EXAMPLE,
    KANE,
    against,
    array,
    friction_forward,
    full_stick,
    pushed,
    with_masses_swapped,
    without_lever,
    without_restitution,
)

F = Fraction


def same(*pairs: Any) -> bool:
    """Whether all values are equal, and exact: no double has crept in."""
    for found, wanted in pairs:
        assert all(isinstance(x, Fraction) for x in np.ravel(np.asarray(found, dtype=object))), found
        if not np.all(np.asarray(found) == np.asarray(wanted)):
            return False
    return True


def square(v: Any) -> Any:
    return v @ v


# ---- on a line ---------------------------------------------------------------------------------------------------


@given(NUMBERS, NUMBERS, HEAVY, HEAVY, SHARES)
def test_line_momentum_restitution_and_energy(va: Any, vb: Any, wa: Any, wb: Any, e: Any) -> None:
    after = impact_on_line(va, vb, wa, wb, e)
    assert after.velocity_a / wa + after.velocity_b / wb == va / wa + vb / wb
    assert after.velocity_b - after.velocity_a == -e * (vb - va)
    assert after.velocity_b - vb == wb * after.impulse
    gain = (after.velocity_a**2 - va**2) / wa + (after.velocity_b**2 - vb**2) / wb
    assert gain == 0 if e == 1 else gain < 0 or va == vb


@given(NUMBERS, NUMBERS, MASSES, MASSES, SHARES, NUMBERS)
def test_line_galilei_swap_and_return(va: Any, vb: Any, wa: Any, wb: Any, e: Any, shift: Any) -> None:
    after = impact_on_line(va, vb, wa, wb, e)
    moved = impact_on_line(va + shift, vb + shift, wa, wb, e)
    assert (moved.velocity_a, moved.velocity_b) == (after.velocity_a + shift, after.velocity_b + shift)
    swapped = impact_on_line(vb, va, wb, wa, e)
    assert (swapped.velocity_b, swapped.velocity_a, -swapped.impulse) == (
        after.velocity_a,
        after.velocity_b,
        after.impulse,
    )
    bounced = elastic_on_line(va, vb, wa, wb)
    back = elastic_on_line(bounced.velocity_a, bounced.velocity_b, wa, wb)
    assert (back.velocity_a, back.velocity_b) == (va, vb)


@given(NUMBERS, NUMBERS, HEAVY)
def test_special_cases_of_the_lecture(va: Any, vb: Any, w: Any) -> None:
    swap = elastic_on_line(va, vb, w, w)
    assert (swap.velocity_a, swap.velocity_b) == (vb, va)
    flip = elastic_on_line(F(0), vb, F(0), w)
    assert (flip.velocity_a, flip.velocity_b) == (0, -vb)
    average = inelastic_on_line(va, vb, w, w)
    assert average.velocity_a == average.velocity_b == (va + vb) / 2
    stop = inelastic_on_line(F(0), vb, F(0), w)
    assert (stop.velocity_a, stop.velocity_b) == (0, 0)
    still = impact_on_line(va, vb, F(0), F(0), F(1, 2))
    assert (still.velocity_a, still.velocity_b, still.impulse) == (va, vb, 0)


@pytest.mark.parametrize(
    ("wrong", "law"),
    [
        (lambda va, vb, wa, wb, e: impact_on_line(va, vb, wb, wa, e), "momentum"),
        (lambda va, vb, wa, wb, e: impact_on_line(va, vb, wa, wb, 0), "restitution"),
        (lambda va, vb, wa, wb, e: impact_on_line(vb, va, wa, wb, e), "momentum"),
    ],
)
def test_line_laws_fail_on_wrong_formulas(wrong: Callable[..., Any], law: str) -> None:
    va, vb, wa, wb, e = F(3), F(-1), F(1), F(1, 2), F(1, 2)
    after = wrong(va, vb, wa, wb, e)
    kept = after.velocity_a / wa + after.velocity_b / wb == va / wa + vb / wb
    reversed_ = after.velocity_b - after.velocity_a == -e * (vb - va)
    assert not {"momentum": kept, "restitution": reversed_}[law]


# ---- particles ---------------------------------------------------------------------------------------------------


@given(VECTORS, NORMALS)
def test_split(v: Any, n: Any) -> None:
    along, across = split(v, n)
    assert same((along + across, v), (across @ n, 0), (np.cross(along, n), 0))


@given(VECTORS, VECTORS, HEAVY, HEAVY, NORMALS, SHARES, SHARES, RUBS, st.booleans())
def test_particles(va: Any, vb: Any, wa: Any, wb: Any, n: Any, e: Any, damping: Any, mu: Any, coulomb: bool) -> None:
    options = {"friction": mu} if coulomb else {"damping": damping}
    after = impact_of_particles(va, vb, wa, wb, n, e, **options)
    u, v = vb - va, after.velocity_b - after.velocity_a
    assert same((after.velocity_a / wa + after.velocity_b / wb, va / wa + vb / wb), (n @ v, -e * (n @ u)))
    assert same((after.velocity_b, vb + wb * after.impulse), (after.velocity_a, va - wa * after.impulse))
    gain = (square(after.velocity_a) - square(va)) / wa + (square(after.velocity_b) - square(vb)) / wb
    assert gain <= 0
    before_across, after_across = split(u, n)[1], split(v, n)[1]
    if not coulomb:
        assert same((after_across, (1 - damping) * before_across))
        assert gain == 0 or e < 1 or damping > 0
        return
    normal, aside = n @ after.impulse, np.cross(n, after.impulse)
    assert same((np.cross(after_across, before_across), 0))
    assert after_across @ before_across >= 0, "friction does not turn sliding around"
    if n @ u >= 0 or mu == 0:
        assert same((aside, 0))
    else:
        assert square(aside) <= (mu * normal) ** 2
        sticks = not after_across.any()
        assert sticks or square(aside) > (mu * normal) ** 2 * (1 - F(1, 2**100)), "no less friction than there is"


@given(VECTORS, VECTORS, MASSES, MASSES, NORMALS, SHARES, RUBS, VECTORS)
def test_particles_galilei_swap_and_return(
    va: Any, vb: Any, wa: Any, wb: Any, n: Any, e: Any, mu: Any, shift: Any
) -> None:
    after = impact_of_particles(va, vb, wa, wb, n, e, friction=mu)
    moved = impact_of_particles(va + shift, vb + shift, wa, wb, n, e, friction=mu)
    assert same((moved.velocity_a, after.velocity_a + shift), (moved.velocity_b, after.velocity_b + shift))
    swapped = impact_of_particles(vb, va, wb, wa, -n, e, friction=mu)
    assert same((swapped.velocity_b, after.velocity_a), (swapped.velocity_a, after.velocity_b))
    longer = impact_of_particles(va, vb, wa, wb, 3 * n, e)
    assert same((longer.velocity_a, impact_of_particles(va, vb, wa, wb, n, e).velocity_a))
    bounced = impact_of_particles(va, vb, wa, wb, n, 1)
    back = impact_of_particles(bounced.velocity_a, bounced.velocity_b, wa, wb, n, 1)
    assert same((back.velocity_a, va), (back.velocity_b, vb))


@given(VECTORS, VECTORS, HEAVY, HEAVY, NORMALS)
def test_merging_is_not_restitution_0(va: Any, vb: Any, wa: Any, wb: Any, n: Any) -> None:
    after = merge_particles(va, vb, wa, wb)
    assert same((after.velocity_a, after.velocity_b), (after.velocity_a * (1 / wa + 1 / wb), va / wa + vb / wb))
    only_normal = impact_of_particles(va, vb, wa, wb, n, 0)
    slides = split(vb - va, n)[1].any()
    assert same((after.velocity_a, only_normal.velocity_a)) != bool(slides)
    both = impact_of_particles(va, vb, wa, wb, n, 0, damping=1)
    assert same((both.velocity_a, after.velocity_a), (both.velocity_b, after.velocity_b))


def test_an_immovable_particle() -> None:
    wall, ball = array(0, 0, 0), array(2, 0, -3)
    up = array(0, 0, 5)
    assert same((impact_of_particles(wall, ball, F(0), F(1), up, F(1)).velocity_b, array(2, 0, 3)))
    dumped = impact_of_particles(wall, ball, F(0), F(1), up, F(1), damping=F(1, 4))
    assert same((dumped.velocity_b, array(F(3, 2), 0, 3)), (dumped.velocity_a, wall))
    assert same((merge_particles(wall, ball, F(0), F(1)).velocity_b, wall))
    both = merge_particles(wall, ball, F(0), F(0))
    assert same((both.velocity_b, ball), (both.impulse, wall))


# ---- rigid bodies ------------------------------------------------------------------------------------------------


def residuals(scene: Scene, after_a: RigidBody, after_b: RigidBody) -> Residuals:
    found = certify(*scene.question, after_a=after_a, after_b=after_b)
    assert not isinstance(found, list)
    return found.residuals


def broken(found: Residuals) -> set[str]:
    """Names of the laws that do not hold."""
    names = {name for name in ("linear_a", "linear_b", "angular_a", "angular_b") if any(getattr(found, name))}
    names |= {"restitution"} if found.restitution else set()
    return (
        names
        | {name for name in ("pressure", "cone") if getattr(found, name) < 0}
        | ({"energy"} if found.energy > 0 else set())
    )


@given(scenes())
def test_all_laws_of_rigid_bodies_hold(scene: Scene) -> None:
    assume(approach(scene.a, scene.b, scene.point, scene.normal) < 0)
    after = impact_of_bodies(*scene.question)
    found = residuals(scene, after.a, after.b)
    assert broken(found) == set()
    if scene.restitution == 1 and not scene.friction:
        assert found.energy == 0
    u = after.b.velocity_at(scene.point) - after.a.velocity_at(scene.point)
    slides = np.cross(scene.normal, u).any()
    assert not (after.sticks and scene.restitution == 0 and slides)


@given(scenes(HEAVY), VECTORS)
def test_momenta_and_energy_of_rigid_bodies(scene: Scene, about: Any) -> None:
    """By their definitions, and whether the bodies approach or not."""
    scene = scene if approach(scene.a, scene.b, scene.point, scene.normal) < 0 else scene.without_friction()
    a, b = scene.a, scene.b
    after = impact_of_bodies(*scene.question)
    assert same((after.a.momentum() + after.b.momentum(), a.momentum() + b.momentum()))
    angular = a.angular_momentum(about) + b.angular_momentum(about)
    assert same((after.a.angular_momentum(about) + after.b.angular_momentum(about), angular))
    gain = (after.a.kinetic_energy() + after.b.kinetic_energy()) - (a.kinetic_energy() + b.kinetic_energy())
    assert gain <= 0
    assert gain == 0 or scene.restitution < 1 or scene.friction > 0
    u = b.velocity_at(scene.point) - a.velocity_at(scene.point)
    v = after.b.velocity_at(scene.point) - after.a.velocity_at(scene.point)
    assert same((scene.normal @ v, -scene.restitution * (scene.normal @ u)))
    assert same((after.b.velocity, b.velocity + b.inverse_mass * after.impulse))


@given(scenes(), VECTORS)
def test_rigid_galilei_and_swap(scene: Scene, shift: Any) -> None:
    a, b, point, normal, e, mu = scene.question
    after = impact_of_bodies(*scene.question)
    fast_a, fast_b = (body.with_velocities(body.velocity + shift, body.angular_velocity) for body in (a, b))
    fast = impact_of_bodies(fast_a, fast_b, point, normal, e, mu)
    assert same((fast.a.velocity, after.a.velocity + shift), (fast.b.velocity, after.b.velocity + shift))
    assert same((fast.a.angular_velocity, after.a.angular_velocity))
    swapped = impact_of_bodies(b, a, point, -normal, e, mu)
    assert same((swapped.b.velocity, after.a.velocity), (swapped.a.velocity, after.b.velocity))
    assert same((swapped.b.angular_velocity, after.a.angular_velocity), (swapped.impulse, -after.impulse))
    elsewhere = impact_of_bodies(a.moved(shift), b.moved(shift), point + shift, normal, e, mu)
    assert same((elsewhere.a.velocity, after.a.velocity), (elsewhere.b.angular_velocity, after.b.angular_velocity))


@given(scenes())
def test_elastic_impacts_run_backwards(scene: Scene) -> None:
    after = impact_of_bodies(scene.a, scene.b, scene.point, scene.normal, 1)
    back = impact_of_bodies(after.a, after.b, scene.point, scene.normal, 1)
    for before, again in ((scene.a, back.a), (scene.b, back.b)):
        assert same((again.velocity, before.velocity), (again.angular_velocity, before.angular_velocity))


@given(scenes())
def test_impacts_through_the_centres_are_those_of_particles(scene: Scene) -> None:
    """A ball turns only by friction, so that without it there is nothing but the particles' formula."""
    middle = RigidBody(scene.point, scene.a.velocity, scene.a.angular_velocity, scene.a.inverse_mass, scene.a.inertia)
    other = scene.b.moved(scene.point + 2 * scene.normal - scene.b.position)
    found = impact_of_bodies(middle, other, scene.point + scene.normal, scene.normal, scene.restitution)
    known = impact_of_particles(
        middle.velocity, other.velocity, middle.inverse_mass, other.inverse_mass, scene.normal, scene.restitution
    )
    assert same((found.a.velocity, known.velocity_a), (found.b.velocity, known.velocity_b))
    assert same((found.impulse, known.impulse), (found.b.angular_velocity, other.angular_velocity))


# ---- formulas that are wrong on purpose --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "scene", "law"),
    [
        (against, EXAMPLE, "restitution"),
        (against, EXAMPLE, "pressure"),
        (without_restitution, EXAMPLE, "restitution"),
        (with_masses_swapped, EXAMPLE, "linear_b"),
        (without_lever, EXAMPLE, "angular_b"),
        (full_stick, EXAMPLE, "cone"),
        (full_stick, KANE, "energy"),
        (friction_forward, EXAMPLE, "energy"),
    ],
)
def test_laws_fail_on_wrong_formulas(wrong: Callable[[Scene], Any], scene: Scene, law: str) -> None:
    assert law in broken(residuals(scene, *wrong(scene)))
    right = impact_of_bodies(*scene.question)
    assert broken(residuals(scene, right.a, right.b)) == set()


def test_pushed_by_the_impulse_is_the_outcome() -> None:
    """The wrong formulas above are built right, but for what is wrong with them."""
    for scene in (EXAMPLE, KANE):
        after = impact_of_bodies(*scene.question)
        a, b = pushed(scene, after.impulse)
        assert same((a.velocity, after.a.velocity), (b.angular_velocity, after.b.angular_velocity))


def test_kanes_paradox() -> None:
    """The usual formula gains energy here; the one used reverses the normal velocity as well, and loses some."""
    usual = residuals(KANE, *full_stick(KANE))
    assert broken(usual) == {"energy"}
    after = impact_of_bodies(*KANE.question)
    found = residuals(KANE, after.a, after.b)
    assert after.sticks
    assert found.restitution == 0
    assert found.energy < 0 < usual.energy


# ---- one body from two -------------------------------------------------------------------------------------------


@given(scenes(HEAVY))
def test_joined_bodies_are_one(scene: Scene) -> None:
    a, b, about = scene.a, scene.b, scene.normal
    after = join_bodies(a, b)
    assert same((after.a.angular_velocity, after.b.angular_velocity))
    assert same((after.a.velocity_at(scene.point), after.b.velocity_at(scene.point)))
    assert same((after.a.momentum() + after.b.momentum(), a.momentum() + b.momentum()))
    before = a.angular_momentum(about) + b.angular_momentum(about)
    assert same((after.a.angular_momentum(about) + after.b.angular_momentum(about), before))
    gain = (after.a.kinetic_energy() + after.b.kinetic_energy()) - (a.kinetic_energy() + b.kinetic_energy())
    assert gain <= 0
    assert same((after.b.velocity, b.velocity + b.inverse_mass * after.impulse))
    change = after.b.angular_momentum(b.position) - b.angular_momentum(b.position)
    assert same((after.angular_impulse, change))


@given(scenes())
def test_joined_to_an_immovable_body(scene: Scene) -> None:
    """The other body takes its motion; two keep theirs. A receives the opposite of what B does, at the same point."""
    a, b = scene.a, scene.b
    after = join_bodies(a, b)
    for fixed, now in ((a, after.a), (b, after.b)):
        if fixed.inverse_mass == 0:
            assert same((now.velocity, fixed.velocity), (now.angular_velocity, fixed.angular_velocity))
    if a.inverse_mass + b.inverse_mass > 0:
        assert same((after.a.velocity_at(scene.point), after.b.velocity_at(scene.point)))
    else:
        assert same((after.impulse, 0), (after.angular_impulse, 0))
    if a.inverse_mass > 0:
        change = after.a.angular_momentum(b.position) - a.angular_momentum(b.position)
        assert same((-after.angular_impulse, change))
    swapped = join_bodies(b, a)
    assert same((swapped.b.velocity, after.a.velocity), (swapped.a.angular_velocity, after.b.angular_velocity))
