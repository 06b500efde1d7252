"""The picture of a bucket's witness: what is shown, from where, with which marks, and what has to be said of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from oracles.outcome import Bucket, Finding
from oracles.scene import Scene
from oracles.world import is_flat
from refimpl.linear import Array, norm
from refimpl.shapes import Point, Proxy, Ray
from reports import text
from reports.viewer import marks
from reports.viewer.cut import Shown, shown
from reports.viewer.flat import in_space
from reports.viewer.frame import FROM_ABOVE, Frame, View, best_view, choose, exponent_of
from reports.viewer.marks import Mark
from reports.viewer.said import said
from reports.viewer.solids import BEYOND_DRAWING, Line, Plane, Solid, solids

PIXEL = 1 / 150
"""What cannot be seen at first, in radii of the picture."""

LONGEST_LABEL = 300


@dataclass(frozen=True)
class Picture:
    """All that is drawn of a bucket.

    Attributes
    ----------
    a, b, ghost
        The bodies; and those of the certificate, where it speaks of others.
    size
        The picture's radius in the scene's own lengths; may be infinite.
    said
        Layer and words of what the engine and the reference answer, in the fewest words.
    label
        What a screen reader says.
    notes
        How the picture differs from the scene, in sentences.
    names
        What the two bodies are called; without names they are A and B, and have these letters.
    """

    a: list[Solid]
    b: list[Solid]
    ghost: list[Solid]
    marks: list[Mark]
    view: View
    size: float
    said: list[tuple[str, str]]
    label: str
    notes: list[str]
    engine: str
    names: tuple[str, str] | None = None


def picture_of(bucket: Bucket) -> Picture:
    """Picture of the bucket's witness."""
    with np.errstate(all="ignore"):  # what cannot be held in doubles is left out, and is told
        return _picture_of(bucket)


def _picture_of(bucket: Bucket) -> Picture:
    finding = in_space(bucket.witness)
    scene, proof_scene = finding.scene, _proof_scene(finding)
    exponent = exponent_of(
        [float(scene.a.magnitude), float(scene.b.magnitude), *_positions(scene.a), *_positions(scene.b)]
    )
    (body_a, told_a), (body_b, told_b) = solids(scene.a, exponent), solids(scene.b, exponent)
    frame = choose(exponent, body_a, body_b, _anchors(finding, exponent), _gap(finding, exponent))
    a, b = shown("A", body_a, frame), shown("B", body_b, frame)
    ghosts = [
        shown("", solids(theirs, exponent)[0], frame)
        for theirs in _others(finding, proof_scene)
        if not (_same(scene.a, theirs) or _same(scene.b, theirs))
    ]
    found = _marks(finding, proof_scene, frame, _spare(a, b))
    told = [f"{name} is drawn with {' and '.join(words)}" for name, words in (("A", told_a), ("B", told_b)) if words]
    told += [f"{name} {BEYOND_DRAWING}" for name, body in (("A", body_a), ("B", body_b)) if not body]
    notes = [*_on_scale(finding, frame), *told, *a.notes, *b.notes, *found.notes]
    return Picture(
        a=a.parts,
        b=b.parts,
        ghost=[part for ghost in ghosts for part in ghost.parts],
        marks=found.marks,
        view=FROM_ABOVE if is_flat(bucket.witness.scene.b) else _view(a, b, found.marks),
        size=frame.size,
        said=said(finding),
        label=_label(bucket.witness),
        notes=[f"{note}." for note in dict.fromkeys(notes)],
        engine=text.visible(bucket.engine, limit=40),
    )


def _others(finding: Finding, proof_scene: Scene | None) -> tuple[Proxy, ...]:
    """What is drawn faintly: the proxies of the proof; of a sweep both where they meet, or where the engine says so."""
    if finding.scene.course is None:
        return () if proof_scene is None else (proof_scene.a, proof_scene.b)
    return marks.at_contact(finding.scene, _texts_only(finding.reference), _texts_only(finding.answer)) or ()


def _positions(shape: Proxy) -> list[float]:
    """Coordinates of a shape's place, of which its magnitude need not tell."""
    found = [abs(x) for x in np.asarray(shape.reference_point).tolist()]
    return [x for x in found if math.isfinite(x)]


def _proof_scene(finding: Finding) -> Scene | None:
    """The scene of the certificate, where it lies in this one's space.

    That is another pose or form of its proxies, or one of them and a witness; a proof about a normal's length is not.
    """
    scene, other = finding.scene, finding.verdict.proof_scene
    if other is None:
        return scene
    known = any(_same(ours, theirs) for ours in (scene.a, scene.b) for theirs in (other.a, other.b))
    formed = (type(other.a), type(other.b)) == (type(scene.a), type(scene.b))
    return other if known or formed or _is_witness(other.a, finding.answer) else None


def _is_witness(shape: Proxy, answer: object) -> bool:
    """Whether a shape is one of the points that the engine named."""
    said = _texts_only(answer)
    named = [marks.vector(said.get(name)) for name in ("on_a", "on_b", "point")]
    return isinstance(shape, Point) and tuple(shape.position.tolist()) in named


def _same(one: Proxy, other: Proxy) -> bool:
    return one is other or (type(one) is type(other) and np.array_equal(one.pack(), other.pack()))


def _anchors(finding: Finding, exponent: int) -> list[Array]:
    """True points, scaled: they belong into the picture."""
    truth = _texts_only(finding.reference)
    said = [marks.vector(truth.get(name)) for name in ("on_a", "on_b", "point")]
    points = [np.ldexp(np.array(place), -exponent) for place in said if place is not None]
    if finding.scene.impact is not None:
        points.append(np.ldexp(finding.scene.impact.point, -exponent))
    if finding.scene.course is not None:
        points += [np.ldexp(shape.reference_point, -exponent) for shape in _others(finding, None)]
    return [point for point in points if np.isfinite(point).all()]


def _spare(a: Shown, b: Shown) -> Array:
    """Where a normal without a point stands: half-way between the middles of what is shown."""
    middles = []
    for side in (a, b):
        corners = [part.corners() for part in side.parts if len(part.corners())]
        if corners:
            every = np.concatenate(corners)
            middles.append(every.min(axis=0) / 2 + every.max(axis=0) / 2)
    return np.clip(np.mean(middles, axis=0), -1.0, 1.0) if middles else np.zeros(3)


def _marks(finding: Finding, proof_scene: Scene | None, frame: Frame, spare: Array) -> marks.Marks:
    """All marks; the engine's are drawn over the true ones."""
    scene = finding.scene
    engine, truth = _texts_only(finding.answer), _texts_only(finding.reference)
    if scene.impact is not None:
        found = marks.of_impact(scene, engine, truth, frame)
    else:
        found = marks.of_answer("truth", truth, scene, frame, spare)
        own = marks.of_answer("engine", engine, scene, frame, spare)
        found = marks.Marks(found.marks + own.marks, found.notes + own.notes)
        ways = marks.of_course(scene, frame)
        found = marks.Marks(ways.marks + found.marks, ways.notes + found.notes)
    if not any(mark.layer == "engine" for mark in found.marks):
        found.notes.append("The engine names nothing that could be drawn here")
    if proof_scene is not None:
        found.marks = marks.of_proof(finding.verdict.certificate, proof_scene, frame).marks + found.marks
    return found


def _texts_only(answer: object) -> Mapping[str, object]:
    """An answer by names that are texts; a hostile engine's may be anything."""
    return {k: v for k, v in answer.items() if isinstance(k, str)} if isinstance(answer, Mapping) else {}


def _gap(finding: Finding, exponent: int = 0) -> float:
    """Proven gap or depth of the scene, scaled; NaN where the proof is about something else, or has no end."""
    scene, verdict = finding.scene, finding.verdict
    if scene.motion is not None or isinstance(scene.a, Ray):
        return math.nan
    if verdict.proof_scene is not None and verdict.proof_scene.id != scene.id:
        return math.nan
    found = max(float(verdict.lower), -float(verdict.upper))
    return float(np.ldexp(found, -exponent)) if math.isfinite(found) else math.nan


def _on_scale(finding: Finding, frame: Frame) -> list[str]:
    """What is too small or too large to be seen."""
    notes = ["The picture shows the surroundings of the smaller of the two"] if frame.focused else []
    gap, what = _gap(finding), "gap" if finding.verdict.lower > 0 else "overlap"
    if finding.related is not None:
        notes.append(f"The other scene, by the relation “{text.visible(finding.related.relation, 60)}”, is not drawn")
    if 0 < (seen := frame.length(gap)) < PIXEL:
        notes.append(f"The {what} of {text.short(gap)} is {seen:.1g} of the picture's radius: too small to be seen")
    return notes


def _view(a: Shown, b: Shown, found: list[Mark]) -> View:
    """Contacts are seen from the side, planes from outside."""
    normals = [m.to - m.at for m in found if m.kind == "arrow" and m.label == "n"]
    normals += [m.to for m in found if m.kind == "plane"]
    lines = [part.end - part.start for side in (a, b) for part in side.parts if isinstance(part, Line)]
    planes = [part.normal for side in (a, b) for part in side.parts if isinstance(part, Plane)]
    across = [v / norm(v) for v in [*normals[:2], *lines[:1]] if norm(v) > 0]
    return best_view(across or planes[:1], planes)


def _label(finding: Finding) -> str:
    """Say what is drawn, for those who do not see it."""
    scene = finding.scene
    drawn = f"{_named(scene.a)} A and {_named(scene.b)} B"
    claim = text.visible(finding.verdict.claim, limit=LONGEST_LABEL)
    return f"{drawn}: {claim}" if claim else f"{drawn}."


def _named(shape: Proxy) -> str:
    return type(shape).__name__
