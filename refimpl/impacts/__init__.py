"""Impacts: the response half of the lecture, from two masses on a line to rigid bodies with friction.

Every formula is written once, broadcasts over batches, and runs on doubles, which are computed with twice their
precision and rounded once, and unchanged on `fractions.Fraction`, where it is exact.
"""

from refimpl.impacts.bodies import RigidBody, inertia_tensor
from refimpl.impacts.constraints import ParticleBody, impact_between, impact_with_plane, step
from refimpl.impacts.line import LineImpact, elastic_on_line, impact_on_line, inelastic_on_line
from refimpl.impacts.plastic import JoinedImpact, join_bodies
from refimpl.impacts.points import ParticleImpact, impact_of_particles, merge_particles, split
from refimpl.impacts.response import Response, respond
from refimpl.impacts.rigid import BodyImpact, approach, impact_of_bodies

__all__ = [
    "BodyImpact",
    "JoinedImpact",
    "LineImpact",
    "ParticleBody",
    "ParticleImpact",
    "Response",
    "RigidBody",
    "approach",
    "elastic_on_line",
    "impact_between",
    "impact_of_bodies",
    "impact_of_particles",
    "impact_on_line",
    "impact_with_plane",
    "inelastic_on_line",
    "inertia_tensor",
    "join_bodies",
    "merge_particles",
    "respond",
    "split",
    "step",
]
