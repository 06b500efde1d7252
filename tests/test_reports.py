"""What people read: complete, consistent, and harmless whatever an engine says."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from fractions import Fraction
from typing import get_args

import pytest

import refimpl
from oracles.accuracy import Accuracy, Errors, Spread
from oracles.batch import Batch
from oracles.course import Course
from oracles.outcome import COMPARED, FINDINGS, Kind, Related, Run, State, SupportNote, Verdict
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST
from refimpl import Composite, ConvexPolyhedron, flat
from refimpl.proof import Certificate, certify, certify_sweep, claims
from reports import cells as cells_of_page
from reports import findings, html, markdown, matrix, proofs, shapes, summary, tables, text
from reports.content import what_ran
from tests.sample_run import A_BOX, BALL, IN_SPACE, STONE, WEDGE, Page, sample_run


@pytest.fixture(scope="module")
def run() -> Run:
    return sample_run()


@pytest.fixture(scope="module")
def page(run: Run) -> Page:
    return Page(html.render(run))


@pytest.fixture(scope="module")
def notes(run: Run) -> str:
    return markdown.render(run)


# -- counts --------------------------------------------------------------------------------------------------


def amount(entry: tables.Entry) -> int:
    return int(entry.text.replace(text.THIN, ""))


def test_summary_adds_up(run: Run) -> None:
    table = tables.summary(run)
    kinds = [column.title for column in table.columns]
    sums: dict[str, int] = {}
    for row in table.rows:
        engine, _, query = row[0].text.partition(" · ")
        by_kind = dict(zip(kinds[1:], map(amount, row[1:]), strict=True))
        parts = sum(n for kind, n in by_kind.items() if kind not in ("compared", "skipped"))
        assert by_kind["compared"] == parts
        if query:
            sums[engine] = sums.get(engine, 0) + parts
            assert parts == run.total(engine=engine, query=query, kinds=COMPARED)
    assert sums == {engine: run.total(engine=engine, kinds=COMPARED) for engine in run.engines}


def test_coverage_and_regimes_add_up(run: Run) -> None:
    coverage = [row for table in tables.coverage(run) for row in table.rows]
    assert all(amount(row[1]) == sum(map(amount, row[2:])) for row in coverage)
    answers = sum(run.total(engine=engine, kinds=COMPARED) for engine in run.engines)
    assert sum(amount(row[1]) for row in coverage) == answers
    assert sum(amount(row[2]) for row in tables.regime_table(run).rows) == answers


def test_matrix_has_every_pair_and_every_cell(run: Run) -> None:
    rows = [row for table in matrix.matrices(run, {}) for row in table.rows]
    assert sorted(row[0].text for row in rows) == sorted({cell.pair for cell in IN_SPACE})
    assert len(rows) == len(refimpl.table())
    assert sum(len(row) - 1 for row in rows) == len(run.engines) * len(IN_SPACE)


def test_page_has_every_cell_with_what_the_filters_ask_for(run: Run) -> None:
    rows = cells_of_page.rows(run)
    by_cell: Counter[tuple[str, str, str, bool]] = Counter()
    for (engine, query, pair, _, kind), number in run.counts.items():
        by_cell[engine, query, pair, True] += number * (kind in FINDINGS)
        by_cell[engine, query, pair, False] += number * (kind in COMPARED)
    shown = {(e, row.query, row.pair): cell for row in rows for e, cell in zip(run.engines, row.cells, strict=True)}
    assert shown.keys() == {(e, cell.query, cell.pair) for e in run.engines for cell in IN_SPACE}
    for key, cell in shown.items():
        its = [bucket for bucket in run.buckets if (bucket.engine, bucket.query, bucket.pair) == key]
        assert ("new" in cell.flags) == any(bucket.state is State.NEW for bucket in its)
        assert ("unsupported" in cell.flags) == (run.support[key].kind == "unsupported")
        assert ("wrong" in cell.flags) == (by_cell[*key, True] > 0) == (cell.mark.startswith("✗"))
        assert (cell.compared or 0) == by_cell[*key, False]
        assert cell.link == (f"b-{its[0].id}" if its else "")
        assert cell.worst == max((bucket.worst for bucket in its if bucket.worst), default=None)
    assert {key for key, cell in shown.items() if "stale" in cell.flags} == {("fcl", DISTANCE, "Box–Box")}
    assert {(row.query, row.pair) for row in rows if row.differ} >= {(BOOLEAN, "Sphere–Capsule")}
    assert not any(row.differ for row in rows if row.query == RAYCAST)


def test_cells_without_findings_have_the_largest_error_that_was_measured() -> None:
    run = Run(0, 1.0, "", engines=["e"], support={("e", DISTANCE, "Box–Box"): SupportNote("native", "")})
    run.counts["e", DISTANCE, "Box–Box", "generic", Kind.AGREES] = 5
    spread = Spread(0.0, 1e-9, 2e-9)
    run.accuracy = Accuracy((Errors("e", DISTANCE, "Box–Box", "", 5, 5, 0, 0, spread, spread),))
    ((cell,),) = (row.cells for row in cells_of_page.rows(run))
    assert (cell.mark, cell.worst, cell.worst_text) == ("✓", 2e-9, "2e-09")


def test_findings_are_rare_below_a_hundredth_of_all_answers_to_a_pair() -> None:
    run = Run(0, 1.0, "", engines=["e"])
    run.counts["e", DISTANCE, "Box–Box", "generic", Kind.AGREES] = 500
    run.counts["e", BOOLEAN, "Box–Box", "generic", Kind.AGREES] = 490
    run.counts["e", BOOLEAN, "Box–Box", "deep", Kind.WRONG] = 9
    assert cells_of_page.rare(run) == {("e", "Box–Box")}
    run.counts["e", BOOLEAN, "Box–Box", "deep", Kind.CRASHED] = 2
    assert cells_of_page.rare(run) == set()


def test_engines_whose_names_have_the_same_letters_have_addresses_of_their_own() -> None:
    assert cells_of_page.slugs(["a b", "a-b", "", "Ω"]) == {"a b": "a-b", "a-b": "a-b-1", "": "engine", "Ω": "engine-3"}


def test_pairs_that_nobody_was_asked_are_counted_and_left_out() -> None:
    run = Run(0, 1.0, "", engines=["e"], support={("e", DISTANCE, "Box–Box"): SupportNote("native", "")})
    (table,) = matrix.matrices(run, {})
    assert [row[0].text for row in table.rows] == ["Box–Box"]
    others = len({cell.pair for cell in IN_SPACE if cell.query == DISTANCE}) - 1
    assert table.caption.endswith(f"{others} other pairs not asked")


def test_overview_is_a_triangle_of_every_pair_per_engine(run: Run) -> None:
    overviews = matrix.overviews(run)
    assert len(overviews) == len(run.engines)
    for table in overviews:
        said = {f"{row[0].text}–{c.title}": e for row in table.rows for c, e in zip(table.columns, row, strict=True)}
        assert {pair for pair, entry in said.items() if entry.text and not pair.endswith("–")} == {
            f"{a.__name__}–{b.__name__}" for a, b in refimpl.table()
        }
    bullet = {row[0].text: dict(zip((c.title for c in table.columns), row, strict=True)) for row in overviews[1].rows}
    assert (bullet["HalfSpace"]["HalfSpace"].text, bullet["HalfSpace"]["HalfSpace"].state) == ("–", "unsupported")
    wrong = bullet["ConvexPolyhedron"]["Composite"]
    assert (wrong.text, wrong.state) == ("✗\u202f2", "wrong")


def test_worst_query_of_a_pair_is_the_one_at_a_glance() -> None:
    run = Run(0, 1.0, "", engines=["e"])
    run.support = {("e", query, "Box–Box"): SupportNote("native", "") for query in (DISTANCE, BOOLEAN)}
    run.support["e", CONTACTS, "Box–Box"] = SupportNote("unsupported", "")

    def at_a_glance() -> tuple[str, str]:
        rows = {row[0].text: row for row in matrix.overviews(run)[0].rows}
        entry = rows["Box"][[c.title for c in matrix.overviews(run)[0].columns].index("Box")]
        return entry.state, entry.text

    run.counts["e", DISTANCE, "Box–Box", "generic", Kind.AGREES] = 5
    assert at_a_glance() == ("problem", "!")
    run.counts["e", BOOLEAN, "Box–Box", "generic", Kind.CONVENTION] = 5
    assert at_a_glance() == ("convention", "≈")
    run.counts["e", DISTANCE, "Box–Box", "deep", Kind.CRASHED] = 2
    run.counts["e", BOOLEAN, "Box–Box", "deep", Kind.WRONG] = 3
    assert at_a_glance() == ("wrong", "✗\u202f5")


@pytest.mark.parametrize(
    ("verdicts", "state", "words"),
    [
        ({Kind.AGREES: 1234}, "ok", "✓ 1\u202f234"),
        ({Kind.AGREES: 3, Kind.UNDECIDED: 1}, "ok", "✓ 4"),
        ({Kind.UNDECIDED: 2}, "undecided", "? 2"),
        ({Kind.AGREES: 3, Kind.CONVENTION: 1}, "convention", "≈ 4"),
        ({Kind.AGREES: 3, Kind.CRASHED: 1}, "crashed", "✗ crashed 1 of 4"),
        ({Kind.AGREES: 3, Kind.TIMED_OUT: 2, Kind.SKIPPED: 5}, "timed-out", "✗ timed out 2 of 5"),
        ({Kind.WRONG: 2, Kind.CRASHED: 1, Kind.AGREES: 1}, "wrong", "✗ 2 of 4"),
        ({Kind.REFERENCE_WRONG: 1, Kind.WRONG: 2}, "reference-wrong", "✗ reference wrong 1 of 3"),
        ({Kind.AGREES: 3, Kind.UNSUPPORTED: 2}, "ok", "✓ 3"),
        ({Kind.UNSUPPORTED: 2}, "problem", "! nothing compared"),
        ({Kind.SKIPPED: 5}, "problem", "! nothing compared"),
        ({}, "problem", "! nothing compared"),
    ],
)
def test_matrix_entry_names_the_worst(verdicts: dict[Kind, int], state: str, words: str) -> None:
    run = Run(0, 1.0, "", engines=["e"], support={("e", DISTANCE, "Box–Box"): SupportNote("native", "")})
    run.counts.update({("e", DISTANCE, "Box–Box", "generic", kind): n for kind, n in verdicts.items()})
    box_box = next(row for row in matrix.matrices(run, {})[0].rows if row[0].text == "Box–Box")
    assert (box_box[1].state, box_box[1].text) == (state, words)


def test_audits_of_the_reference_are_no_answers_of_an_engine(run: Run) -> None:
    assert tables.engines(run) == ["fcl", "bullet"]
    assert tables.audit(run) == Counter({Kind.AGREES: 3 * len(refimpl.table())})
    assert tables.summary(run).rows[-1][0] == tables.Entry("refimpl", "audited")


# -- sentences -----------------------------------------------------------------------------------------------


def test_headline_names_what_each_engine_did(run: Run) -> None:
    said = findings.headline(run).replace(text.THIN, "")
    assert re.search(r"fcl is wrong in 1071 of \d+ scenes and did not return on 2 scenes", said)
    assert re.search(r"bullet is wrong in 1250 of \d+ scenes and crashed on 4 scenes", said)
    assert said.endswith("10 buckets (9 new, 1 changed, 1 stale, 1 expected).")


def test_headline_of_a_wrong_reference_says_nothing_else() -> None:
    run = sample_run()
    run.buckets[0].witness = dataclasses.replace(run.buckets[0].witness, verdict=Verdict(Kind.REFERENCE_WRONG))
    assert findings.headline(run).startswith("The reference itself was proven wrong")


def test_time_is_held_against_what_was_asked_for() -> None:
    run = Run(0, 60.0, "", seconds=100.0)
    assert dict(what_ran(run))["time"] == f"100{text.THIN}s of a budget of 60{text.THIN}s"
    run.passes = 2
    assert dict(what_ran(run))["time"] == f"100{text.THIN}s for 2 passes over all cells"


VECTOR = (1.0, 0.0, Fraction(1, 3))
WEIGHTS = ((7, 1.0), (2, Fraction(1, 3)))
LEAF = claims.Separated(VECTOR)
TREE = claims.Split(0, (0,), (LEAF, claims.Split(1, (1,), (LEAF, LEAF))))
PIECE = claims.Piece((VECTOR,) * 4, TREE, 0.5)
CLAIMS: list[tuple[claims.Claim, str]] = [
    (LEAF, "Planes with normal (1.0, 0.0, 1/3)"),
    (claims.Separated(VECTOR, None, (((0, ((0, 1.0),)),), ())), "Shares of a polytope's own planes"),
    (claims.Separated(VECTOR, 2.0), "Up to t = 2.0"),
    (claims.Escape(VECTOR), "Moving B along (1.0, 0.0, 1/3)"),
    (claims.Near(VECTOR, VECTOR), "(1.0, 0.0, 1/3) lies in A"),
    (claims.Near(WEIGHTS, ((3, 1.0),)), "A mean of vertices 2 and 7 lies in A and vertex 3 in B"),
    (claims.Common(VECTOR), "(1.0, 0.0, 1/3) lies in both"),
    (claims.Common(None, 1.5), "At t = 1.5 the ray is inside"),
    (claims.Common(WEIGHTS, 1.5), "inside the solid, at a mean of vertices 2 and 7"),
    (claims.Core(((VECTOR, VECTOR),)), "nearer than the radii reach"),
    (claims.Core(((VECTOR, VECTOR),), ((0, 0, 0),)), "span 1 triangle around a ball"),
    (claims.Core(((VECTOR, VECTOR),) * 3), "span a polygon of 3 corners around the origin"),
    (claims.Core(((VECTOR, VECTOR),), ((0, 0, 0),), directions=True), "go on for ever"),
    (claims.Inscribed(VECTOR, (VECTOR,) * 3, VECTOR, (VECTOR,) * 3, 0.25, (1, 1, 1)), "ball of radius 0.25"),
    (claims.Cover(TREE), "Planes across 3 directions part all convex parts"),
    (claims.Cover(TREE, shift=VECTOR), "Once B is moved by (1.0, 0.0, 1/3)"),
    (claims.Cover(TREE, until=2.5), "Up to t = 2.5"),
    (claims.Part(3, None, claims.Near(VECTOR, VECTOR)), "A's part 3 and B"),
    (claims.Part((4, PIECE), 1, claims.Common(VECTOR)), "The hull of 4 points, widened by 0.5 in A's part 4"),
]


def test_every_claim_has_words() -> None:
    simple, *others = get_args(claims.Claim), *get_args(claims.Simple)
    assert {type(claim) for claim, _ in CLAIMS} == {*simple, *others}
    said = [proofs.claim_in_words(claim) for claim, _ in CLAIMS]
    assert len(set(said)) == len(said)
    for words, (_, named) in zip(said, CLAIMS, strict=True):
        assert named in words
        assert words[0].isupper() or words[0] == "("
        assert words.endswith(".")


def test_certificates_of_the_plane_have_its_words() -> None:
    a, b = flat.Disc([0.0, 0.0], 1.0), flat.Rectangle([1.5, 1.5], [2.0, 3.0])
    motions = Course.translating([4.0, 0.0, 0.0], [0.0, -4.0, 0.0]).flat_motions
    said = [
        proofs.proof_view(found, "", flat=True).claims
        for found in (
            certify(a, b),
            certify(b, b),
            certify(flat.FlatRay([0.0, 2.0], [1.0, 0.0]), b),
            certify_sweep(a, b, *motions),
        )
    ]
    words = " ".join(word for claims_said in said for word in claims_said)
    assert "lines" in words.lower()
    assert "plane" not in words.lower()
    assert "span a polygon of" in words
    places = re.findall(r"\([^()]*,[^()]*\)", words)
    assert len(places) > 4
    assert all(place.count(",") == 1 for place in places)
    assert "Planes" in " ".join(proofs.proof_view(certify(a, b), "").claims)


def test_motions_of_the_plane_have_its_numbers() -> None:
    course = Course.translating([4.0, 0.5, 0.0], [0.0, 0.0, 0.0])
    assert dict(findings.course_in_words(course, 2)) == {"A moves": "by (4.0, 0.5)", "B moves": "rests"}
    batch = Batch.draw_impacts((flat.Disc, flat.Rectangle), 1, (0,), 1)[0]
    motion = batch.scene(IMPACT, 3).impact
    assert motion is not None
    told = dict(findings.motion_in_words(motion, 2))
    assert told["contact"].startswith(f"at ({float(motion.point[0])!r}, {float(motion.point[1])!r}), normal")
    assert told["A moves"].endswith(f"inertia {float(motion.a.inertia[2, 2])!r}")
    assert f"ω = {float(motion.a.angular_velocity[2])!r}," in told["A moves"]


def test_direction_of_long_numbers_is_told_rounded() -> None:
    said = proofs.claim_in_words(claims.Escape((3 * 10**400, -4 * 10**400, Fraction(1, 10**400))))
    assert "about (0.6, -0.8, 0)" in said


def test_long_certificates_are_told_by_their_first_claims() -> None:
    many = Certificate((claims.Cover(claims.Split(0, (0,), (LEAF, LEAF))),) * 200, 0.0, 1.0)
    view = proofs.proof_view(many, "")
    assert len(view.claims) == proofs.MOST_CLAIMS + 1
    assert "188 more claims" in view.claims[-1]


# -- shapes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [BALL, A_BOX, WEDGE])
def test_short_shapes_are_shown_whole(shape: refimpl.Proxy) -> None:
    said = shapes.in_words(shape)
    assert shapes.is_whole(shape)
    rebuilt = eval(said, vars(refimpl))
    assert (rebuilt.pack() == shape.pack()).all()


def test_shape_of_many_numbers_is_named_by_size_and_digest(run: Run, page: Page, notes: str) -> None:
    said = shapes.in_words(STONE)
    assert len(said) < 200
    assert re.search(r"vertices=<120 × 3 numbers, sha256 [0-9a-f]{12}>, position=\[0.0, 0.0, 0.0\]", said)
    assert said == shapes.in_words(STONE.translated([0.0, 0.0, 0.0]))
    other = ConvexPolyhedron.from_vertices(STONE.vertices * 1.5)
    assert shapes.in_words(other) != said
    assert re.search(r"Composite\(\[.*sha256.*, Sphere\(", shapes.in_words(Composite([STONE, BALL])))
    assert not shapes.is_whole(STONE)
    for words in (page.words, notes):
        assert said in words
        assert repr(float(STONE.vertices[60, 0])) not in words
    data = summary.report_data(run)["buckets"][-1]["scene"]["a"]["numbers"]
    assert data == STONE.pack().tolist()


def test_reasons_name_the_pairs_that_share_them(run: Run) -> None:
    run = Run(0, 1.0, "", engines=["e"])
    for query in (DISTANCE, BOOLEAN):
        for pair in ("Sphere–KDOP", "KDOP–KDOP", "KDOP–Box"):
            run.support["e", query, pair] = SupportNote("emulated", "as a hull")
    (row,) = matrix.support_notes(run).rows
    assert row[-1].text == "distance, boolean: KDOP with Sphere, KDOP, Box"


# -- proofs on others ----------------------------------------------------------------------------------------


def test_proof_on_other_proxies_is_shown_with_them(run: Run, page: Page, notes: str) -> None:
    assert "for the Point and the Box of the certificate" in page.words
    for said in (page.words, notes):
        assert "Point(position=[1.0, 0.0, 2.0])" in said


# -- pages ---------------------------------------------------------------------------------------------------


def test_ids_are_unique_and_links_resolve(run: Run, page: Page) -> None:
    ids = page.values("id")
    assert len(ids) == len(set(ids))
    links = page.values("href")
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)
    views = findings.bucket_views(run)
    files = {"report.md", "report.json", *(view.file for view in views), *(view.issue for view in views)}
    assert {link for link in links if not link.startswith(("#", "?show="))} == {*files, "https://example.org/1"}
    assert {f"b-{bucket.id}" for bucket in run.buckets} <= set(ids)
    assert set(page.values("aria-labelledby")) <= set(ids)


def test_page_needs_no_network_and_lets_in_its_own_style_and_script_alone(run: Run, page: Page) -> None:
    assert not page.tags.keys() & {"link", "img", "iframe", "object", "embed", "base"}
    assert not page.values("src")
    assert not any(name.startswith("on") or name == "style" for name, _ in page.attributes)
    written = html.render(run)
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', written)
    inline = [re.findall(rf"<{tag}>(.*?)</{tag}>", written, re.DOTALL) for tag in ("style", "script")]
    assert [len(found) for found in inline] == [page.tags["style"], page.tags["script"]] == [1, 1]
    style, script = (html.digest(found) for (found,) in inline)
    assert policy
    assert policy[1].replace("&#39;", "'") == (
        f"default-src 'none'; style-src '{style}'; script-src '{script}'; base-uri 'none'; form-action 'none'"
    )
    assert not re.search(r"url\(|@import", inline[0][0])


def test_page_is_made_of_proper_tables(run: Run, page: Page) -> None:
    assert page.tags["caption"] == page.tags["table"] > 5
    assert set(page.values("scope")) == {"row", "col", "colgroup"}
    assert page.tags["h1"] == 1


@pytest.mark.parametrize("form", ["html", "markdown"])
def test_every_bucket_is_told_in_full(run: Run, page: Page, notes: str, form: str) -> None:
    said = page.words if form == "html" else notes.replace("\\", "")
    for view, its in zip(findings.bucket_views(run), run.buckets, strict=True):
        for words in (
            view.title,
            view.fact,
            view.story,
            view.severity,
            view.file,
            view.state,
            text.visible(its.cause),
            *(proxy for _, proxy in view.scene),
        ):
            assert words in said
        verdict = its.witness.verdict
        assert repr(verdict.lower) in said
        assert repr(verdict.upper) in said
        for answer in (its.witness.answer, its.witness.reference):
            assert all(text.full(value) in said for name, value in answer.items() if name != "hit")
        if verdict.certificate is not None:
            assert all(words in said for words in proofs.proof_view(verdict.certificate, "").claims)
        assert form == "markdown" or f"python {view.file}" in said


@pytest.mark.parametrize("form", ["html", "markdown"])
def test_both_forms_have_all_rows(run: Run, page: Page, notes: str, form: str) -> None:
    said = page.words if form == "html" else notes.replace("\\", "")
    everything = [tables.summary(run), tables.regime_table(run), matrix.support_notes(run), tables.timing(run)]
    own = (*matrix.matrices(run, {}), *tables.coverage(run)) if form == "markdown" else ()
    for table in (*everything, *own):
        for row in table.rows:
            assert all(entry.text in said for entry in row)


def test_many_buckets_are_all_told() -> None:
    run = sample_run()
    run.buckets = run.buckets[:1] * 120
    for said in (html.render(run), markdown.render(run)):
        assert all(view.file in said for view in findings.bucket_views(run))


def test_run_without_findings_renders() -> None:
    run = sample_run()
    run.buckets.clear()
    assert "None." in Page(html.render(run)).words
    assert "## Findings\n\nNone.\n" in markdown.render(run)


def test_empty_run_renders() -> None:
    run = Run(0, 1.0, "2026-01-01T00:00:00Z", interrupted=True, problems=["nothing ran"])
    for said in (Page(html.render(run)).words, markdown.render(run)):
        assert "The run was interrupted" in said
        assert "nothing ran" in said


def test_markdown_tables_are_well_formed(notes: str) -> None:
    rows = 0
    for block in re.split(r"\n(?!\|)", notes):
        lines = [line for line in block.split("\n") if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in lines}) <= 1
        rows += len(lines)
    assert rows > 200


def test_answers_that_contradict_each_other_are_reported_with_both_scenes() -> None:
    run = sample_run()
    bucket = run.buckets[0]
    finding = bucket.witness
    other = dataclasses.replace(finding.scene, a=finding.scene.b, b=finding.scene.a)
    verdict = dataclasses.replace(
        finding.verdict, kind=Kind.INCONSISTENT, symptom="swapping A and B changes the distance"
    )
    bucket.witness = dataclasses.replace(
        finding, verdict=verdict, related=Related("swapped", other, {"distance": 1.25})
    )
    run.counts[bucket.engine, bucket.query, bucket.pair, "generic", Kind.INCONSISTENT] += 1
    run.relations.update({(bucket.engine, "swapped", bucket.query, kind): 7 for kind in Kind})
    page, text = html.render(run), markdown.render(run)
    for shown in (page, text):
        assert "swapping A and B" in shown
        assert "distance = 1.25" in shown
    assert "engines write each pair once" in text
    assert Kind.INCONSISTENT.value in page
    data = summary.report_data(run)
    assert data["buckets"][0]["related"]["relation"] == "swapped"
    assert data["buckets"][0]["related"]["scene"]["id"] == other.id
    assert {entry["count"] for entry in data["relations"]} == {7}
