"""`proxyproof fit`: what it prints and writes, what other programs make of it, and what it refuses, in one line."""

from __future__ import annotations

import os
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from oracles.exporting import proxies_from_json
from refimpl import load_polyhedron
from refimpl.construct import contains
from reports import cli, viewer
from reports.fit_command import WAYS_OUT
from tests.browser import chromium, visit
from tests.solids import box, prism
from tests.test_loading import obj

bullet = pytest.importorskip("pybullet")
pytest.importorskip("trimesh")

KINDS = ("aabb", "sphere", "capsule", "cylinder", "ellipsoid", "kdop18", "hull", "packed_spheres")
OUTLINE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder, and what was printed."""
    folder = tmp_path_factory.mktemp("fit")
    model = folder / "part <b>.obj"
    model.write_text(obj(prism(OUTLINE)))
    chosen = [word for kind in KINDS for word in ("--proxy", kind.replace("_", "-"))]
    with pytest.MonkeyPatch.context() as patch:
        said: list[str] = []
        patch.setattr("sys.stdout", Written(said))
        patch.setattr("refimpl.construct.scorecard.ENOUGH", 1e-4)
        patch.setattr("refimpl.construct.scorecard.POINTS", 256)
        assert cli.main(["fit", str(model), *chosen, "--mass", "2.5", "--out", str(folder / "out")]) == 0
    return folder / "out", "".join(said)


class Written:
    """A stream that keeps what is written."""

    def __init__(self, said: list[str]) -> None:
        self.write = said.append

    def flush(self) -> None: ...

    def isatty(self) -> bool:
        return False


def test_the_scorecard_is_printed(fitted: tuple[Path, str]) -> None:
    _, said = fitted
    assert "part <b>.obj: 20 faces, volume 4, diagonal 3.742" in said
    lines = [line for line in said.splitlines() if "move" in line]
    assert len(lines) == len(KINDS) + 1
    assert re.search(r"axis-aligned box +\S+\s\S+ +6 +1\.5 .*move, scale, stretch +\S+\s\S+", said)
    assert max(map(len, said.splitlines())) <= 120


def test_the_page_is_whole_and_refers_to_what_is_there(fitted: tuple[Path, str]) -> None:
    folder, _ = fitted
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert page.count('<figure class="scene"') == len(KINDS) + 1
    assert viewer.script() in page
    assert "part &lt;b&gt;.obj" in page
    assert "part <b>" not in page
    linked = re.findall(r'href="([^"#]+)"', page)
    assert {"proxies.json", "sphere.urdf", "hull.urdf"} <= set(linked)
    assert all((folder / name).is_file() for name in linked)
    anchors = set(re.findall(r'href="#([^"]+)"', page))
    assert anchors <= set(re.findall(r'id="([^"]+)"', page))


def test_the_page_comes_to_life_in_a_browser(fitted: tuple[Path, str]) -> None:
    folder, _ = fitted
    with chromium() as started:
        for width, scheme in ((1280, "light"), (390, "dark")):
            options = {"viewport": {"width": width, "height": 844}, "color_scheme": scheme}
            with visit(started, (folder / "index.html").as_uri(), **options) as its:
                its.page.locator("#aabb").scroll_into_view_if_needed()
                its.page.wait_for_selector("#aabb figure.live")
                buttons = its.page.locator("#aabb .scene-tools button").all_inner_texts()
                assert buttons == ["model", "axis-aligned box", "reset"]
                its.page.locator("#model").scroll_into_view_if_needed()
                its.page.wait_for_selector("#model figure.live")
                assert its.page.locator("#model .scene-tools button").all_inner_texts() == ["model", "reset"]
                assert its.page.evaluate("document.documentElement.scrollWidth") <= width


def test_proxies_read_back_contain_the_model(fitted: tuple[Path, str]) -> None:
    folder, _ = fitted
    proxies = proxies_from_json((folder / "proxies.json").read_text(encoding="utf-8"))
    assert set(proxies) == set(KINDS)
    corners = np.array(prism(OUTLINE)[0])
    for kind in set(KINDS) - {"packed_spheres"}:
        assert contains(proxies[kind], corners).all(), kind


def test_bullet_loads_every_urdf(fitted: tuple[Path, str]) -> None:
    folder, _ = fitted
    client = bullet.connect(bullet.DIRECT)
    try:
        for kind in KINDS:
            body = bullet.loadURDF(str(folder / f"{kind}.urdf"), physicsClientId=client)
            shapes = bullet.getCollisionShapeData(body, -1, physicsClientId=client)
            assert len(shapes) == (8 if kind == "packed_spheres" else 1), kind
            assert bullet.getDynamicsInfo(body, -1, physicsClientId=client)[0] == 2.5
    finally:
        bullet.disconnect(client)


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line on standard error, of a command that writes nothing."""
    assert cli.main(["fit", *arguments, "--proxy", "aabb", "--out", "out"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert re.fullmatch(r"proxyproof: [^\n]+\n", said.err)
    assert not Path("out").exists()
    return said.err


CUBE = obj(box()).encode()
FACES = [line for line in CUBE.splitlines() if line.startswith(b"f")]
PLY = b"ply\nformat %s 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"  # noqa: E501
ROBOT = (
    b'<robot name="r"><link name="l"><collision><geometry><mesh filename="%s"/></geometry></collision></link></robot>'
)
BAD: dict[str, tuple[bytes, str]] = {
    "open.obj": (CUBE.replace(FACES[3], b""), r"open: the edge .* --repair may help: merge_near, then fill_holes"),
    "flipped.obj": (CUBE.replace(FACES[3], b"f " + b" ".join(FACES[3].split()[:0:-1])), r"flipped: .*: turn_outwards"),
    "twice.obj": (CUBE + FACES[0], r"not a surface: .* drop_duplicates"),
    "flat.obj": (CUBE + b"f 1 1 2\n", r"has no area .*: drop_degenerate"),
    "nan.obj": (CUBE.replace(b"v 1.0 1.0 1.0", b"v nan 1.0 1.0"), r"is broken: vertex \d+ of face \d+ is not finite"),
    "infinite.obj": (CUBE.replace(b"v 1.0 1.0 1.0", b"v 1e999 1.0 1.0"), r"is not finite"),
    "large.obj": (CUBE.replace(b" 1.0", b" 1e300"), r"scale it first; see --scale"),
    "crossing.obj": (obj(box(), box((0.5, 0.5, 0.5), (2, 2, 2))).encode(), r"self-intersecting: .*drop_crossing"),
    "nested.obj": (obj(box(), box((0.2, 0.2, 0.2), (0.8, 0.8, 0.8))).encode(), r"flipped: .* inside another surface"),
    "empty.obj": (b"", "holds no triangle"),
    "empty.stl": (b"", "holds no triangle"),
    "really_obj.stl": (CUBE, "holds no triangle"),
    "billion.stl": (b"\0" * 80 + struct.pack("<I", 2**32 - 1), "holds no triangle"),
    "million.stl": (
        b"\0" * 80 + struct.pack("<I", 1_000_000) + bytes(50_000_000),
        "1000000 faces, more than 200000; --repair may help: simplify, or hull",
    ),
    "billion.off": (b"OFF\n1000000000 1000000000 0\n0 0 0\n", "is broken: ValueError"),
    "billion.ply": (PLY % (b"binary_little_endian", 10**9, 10**9) + b"\0\0", "is broken: ValueError"),
    "lies.ply": (PLY % (b"ascii", 3, 10**9) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "open: the edge"),
    "index.obj": (b"v 0 0 0\nf -1 -2 -3\nf 1 2 99999999999\n", "is broken: IndexError"),
    "polygon.obj": (CUBE + b"f" + b" 1" * 2**24, "room for millions"),
    "polygons.ply": (
        (PLY % (b"binary_little_endian", 3, 2**16)).replace(b"int", b"uchar") + bytes(2**24),
        "room for millions",
    ),
    "head.ply": (b"ply\nformat ascii 1.0\n" + b"property float x\n" * 2**16, "its head does not end"),
    "corners.obj": (CUBE + b"f" + b" 1" * 200_000, "200010 faces, more than 200000"),
    "words.stl": (b"solid " + b"(" * 10**6, "holds no triangle"),
    "bomb.urdf": (b'<!DOCTYPE r [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>', "line 1: a document type"),
    "nothing.urdf": (b"<robot/>", "has no link with a collision or visual element"),
    "passwd.urdf": (ROBOT % b"/etc/passwd.stl", "'/etc/passwd.stl': is an absolute path"),
    "outside.urdf": (
        ROBOT % b"../../../x.stl",
        r"'../../../x.stl': .*--root",
    ),
    "web.urdf": (ROBOT % b"http://example.org/x.stl", "only relative paths and package://"),
    "missing.urdf": (ROBOT % b"x.stl", "'x.stl': is not there; name the folder in which .* with --root"),
    "ball.urdf": (
        ROBOT.replace(b'mesh filename="%s"', b'sphere radius="1"'),
        "a sphere is a proxy already; .* --shapes visual",
    ),
    "points.npy": (b"\x93NUMPY\1\0", "holds points, .* --repair may help: hull"),
    "model.step": (b"ISO-10303-21;", "this is step; also read are robots from urdf, and points from xyz"),
    "bomb.dae": (b'<!DOCTYPE r [<!ENTITY a "aa">]><COLLADA>&a;</COLLADA>', "this is dae"),
    "suffixless": (b"x", "without suffix"),
    "\x1b[31m\n.obj": (b"v", r"⟨U\+001B⟩\[31m ⏎ .obj holds no triangle"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_mesh_gets_one_clear_line(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    content, why = BAD[name]
    Path(name).write_bytes(content)
    assert re.search(why, refused(capsys, name))


def test_what_is_no_ordinary_file_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with Path("sparse.stl").open("wb") as file:
        file.truncate(10 << 30)
    os.symlink("loop.obj", "loop.obj")
    os.symlink("/dev/zero", "zero.stl")
    os.mkfifo("pipe.stl")
    Path("folder.obj").mkdir()
    for name, why in (
        ("sparse.stl", "more than 64 MiB"),
        ("loop.obj", "symbolic links"),
        ("zero.stl", "no regular file"),
        ("pipe.stl", "no regular file"),
        ("folder.obj", "no regular file"),
        ("missing.obj", "No such file"),
        ("\0.obj", "must name a mesh file"),
        ("", "must name a mesh file"),
    ):
        assert why in refused(capsys, name), name


def test_what_an_obj_refers_to_is_left_alone(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Materials are not looked for, wherever they are said to be."""
    Path("secret.mtl").write_text("newmtl s\nmap_Kd /etc/passwd\n")
    Path("model.obj").write_bytes(b"mtllib secret.mtl\nmtllib ../../../../etc/passwd\nusemtl s\n" + CUBE)
    opened: list[str] = []
    real = os.open
    monkeypatch.setattr(
        os, "open", lambda path, *rest, **more: (opened.append(str(path)), real(path, *rest, **more))[1]
    )
    assert cli.main(["fit", "model.obj", "--proxy", "aabb", "--out", "out"]) == 0
    assert not any("secret" in path or "passwd" in path for path in opened)
    assert "passwd" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "repairs"),
    [
        ("open.obj", ["fill-holes"]),
        ("flipped.obj", ["turn_outwards"]),
        ("twice.obj", ["DROP_DUPLICATES"]),
        ("flat.obj", ["drop_degenerate"]),
        ("crossing.obj", ["hull"]),
        ("nested.obj", ["keep-largest"]),
    ],
)
def test_a_named_repair_is_the_way_out(name: str, repairs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path(name).write_bytes(BAD[name][0])
    asked = [word for repair in repairs for word in ("--repair", repair)]
    assert cli.main(["fit", name, *asked, "--proxy", "aabb"]) == 0
    assert (Path(f"{Path(name).stem}-proxies") / "index.html").is_file()
    assert "volume 1," in capsys.readouterr().out or name == "crossing.obj"


def test_every_way_out_names_repairs_that_there_are() -> None:
    from refimpl.repairs import REPAIRS  # noqa: PLC0415

    for _, words in WAYS_OUT:
        assert set(re.findall(r"\w+_\w+", words)) <= set(REPAIRS)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--repair", "magic"], "--repair 'magic' is no repair; there are merge_near"),
        (["--proxy", "teapot"], "--proxy 'teapot' is no kind of proxy; there are aabb"),
        (["--scale", "0"], "--scale must be a positive number, got 0"),
        (["--mass", "heavy"], "--mass must be a positive number, got heavy"),
        (["--scale", "1e-300"], "scale it first"),
    ],
)
def test_bad_options_are_refused(arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("cube.obj").write_bytes(CUBE)
    assert why in refused(capsys, "cube.obj", *arguments)


def test_a_folder_of_somebody_else_is_not_written_to(capsys: pytest.CaptureFixture[str]) -> None:
    Path("cube.obj").write_bytes(CUBE)
    Path("site").mkdir()
    Path("site/index.html").write_text("mine")
    Path("taken").write_text("a file")
    for name, why in (("site", "is not ours"), ("taken", "is a file"), ("/proc/x", "cannot write to")):
        assert cli.main(["fit", "cube.obj", "--proxy", "aabb", "--out", name]) == 2
        printed = capsys.readouterr()
        assert why in printed.err
        assert name == "site" or printed.out == "", "refused when all was done"
    assert Path("site/index.html").read_text() == "mine"
    assert len(load_polyhedron("cube.obj").triangles) == 12
