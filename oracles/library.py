"""Libraries of models: a folder of one's own, the models that PyBullet ships, or a few made here.

Files are found at once and read when they are first used. Models stand in families, the folders right below the
library's: choosing a family first keeps a thousand random hulls from crowding out a dozen robots.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from oracles import handmade
from oracles.draws import Draws
from oracles.meshfiles import FORMATS, ModelError
from oracles.models import FORMS, Model, mesh_model, urdf_model

MODELS = (".urdf", *(f".{form}" for form in FORMATS))
MOST_ENTRIES, MOST_MODELS = 100_000, 10_000
TRIES, MOST_TRIED = 8, 200
"""Models of a family that are tried for a form before the next family's turn, and of all families in the end."""


@dataclass
class Library:
    """Models by family.

    Attributes
    ----------
    title
        What reports call it.
    families
        Name of each family, and its models in order.
    unread
        Files and folders that cannot be used at all, each with the reason.
    """

    title: str
    families: dict[str, list[Model]]
    unread: dict[str, str] = field(default_factory=dict)
    lacking: set[str] = field(default_factory=set)
    """Forms that were asked for and not found, so that models made here took the place."""

    @property
    def models(self) -> list[Model]:
        """All models."""
        return [model for family in self.families.values() for model in family]

    def pick(self, draws: Draws, form: str) -> Model:
        """One model that has a form, for a whole batch; of a library that has none, one made here.

        A family is drawn, then one of its models; from there the next that has the form is taken.
        """
        names = list(self.families)
        first = int(draws.choice(range(len(names)))[0])
        start = float(draws.uniform(0.0, 1.0)[0])
        for i in range(len(names)):
            family = self.families[names[(first + i) % len(names)]]
            begin = min(int(start * len(family)), len(family) - 1)
            for j in range(min(len(family), TRIES)):
                model = family[(begin + j) % len(family)]
                if not model.defect(form):
                    return model
        for model in self.models[:MOST_TRIED]:
            if not model.defect(form):
                return model
        self.lacking.add(form)
        return next(model for model in made_here().models if not model.defect(form))

    def read_all(self) -> None:
        """Read every file once; those that cannot be read leave the families and are named in `unread`."""
        for name, family in list(self.families.items()):
            for model in list(family):
                try:
                    model.read()
                except ModelError as error:
                    self.unread[model.name] = str(error)
                    family.remove(model)
            if not family:
                del self.families[name]

    def survey(self) -> Iterator[tuple[Model, dict[str, str]]]:
        """Every model with the defect that keeps it from each form, empty where it has the form."""
        for model in self.models:
            yield model, {form: model.defect(form) for form in FORMS}

    def summary(self) -> str:
        """Title, number of models, and how many files are none that can be read."""
        number = len(self.models)
        unread = f", and {len(self.unread)} that cannot be used" if self.unread else ""
        return f"{self.title}: {number} model{'' if number == 1 else 's'}{unread}"

    def account(self) -> list[str]:
        """What a run's report says: the summary, forms that had to come from elsewhere, files that cannot be used."""
        lacking = [
            f"none of those tried is a {form}: models made in code took the place" for form in sorted(self.lacking)
        ]
        return [self.summary(), *lacking, *(f"{name} {why}" for name, why in self.unread.items())]


def of_folder(folder: Path, title: str = "") -> Library:
    """Library of all OBJ, STL and URDF files below a folder; nothing is read yet.

    Raises
    ------
    ModelError
        When there is no such folder, it cannot be listed, has no model in it, or is too large.
    """
    try:
        if not folder.is_dir():
            raise ModelError(f"{folder} is no folder" if folder.exists() else f"there is no folder {folder}")
    except (OSError, ValueError) as error:
        raise ModelError(f"{str(folder)!r} is no folder: {error}") from None
    library = Library(title or str(folder), {})
    for count, path in enumerate(_files(folder, library.unread)):
        if count >= MOST_MODELS:
            raise ModelError(f"{folder} has more than {MOST_MODELS} models: name a smaller folder")
        name = path.relative_to(folder)
        reader = urdf_model if path.suffix.lower() == ".urdf" else mesh_model
        model = Model(name.as_posix(), lambda reader=reader, path=path: reader(path, folder))  # type: ignore[misc]
        library.families.setdefault(name.parts[0] if len(name.parts) > 1 else "", []).append(model)
    if not library.families:
        raise ModelError(f"{folder} has no model in it: no file ends in {', '.join(MODELS)}")
    return library


def _files(folder: Path, unread: dict[str, str]) -> Iterator[Path]:
    """Files of models in a fixed order; folders that cannot be listed are named in `unread`."""

    def failed(error: OSError) -> None:
        unread[os.path.relpath(error.filename, folder)] = f"cannot be listed: {error.strerror}"

    seen = 0
    for where, folders, names in os.walk(folder, onerror=failed):
        folders.sort()
        seen += len(folders) + len(names)
        if seen > MOST_ENTRIES:
            raise ModelError(f"{folder} has more than {MOST_ENTRIES} entries: name a smaller folder")
        for name in sorted(names):
            if Path(name).suffix.lower() in MODELS:
                yield Path(where) / name


def of_user(folder: Path) -> Library:
    """Library of a user's folder with every file read, so that what cannot be used is known before the run."""
    library = of_folder(folder)
    library.read_all()
    if not library.families:
        name, why = next(iter(library.unread.items()))
        raise ModelError(f"{folder} has no model in it that can be read; {name} {why}")
    return library


@cache
def made_here() -> Library:
    """The models that need no file: each form is had by one of them at least."""
    return Library("models made in code", {"": [Model(name, read) for name, read in handmade.MODELS.items()]})


@cache
def shipped() -> Library:
    """PyBullet's models where `pybullet_data` is installed, else those made here."""
    found = find_spec("pybullet_data")
    if found is None or not found.submodule_search_locations:
        return made_here()
    try:
        of = f"pybullet_data {version('pybullet')}"
    except PackageNotFoundError:
        of = "pybullet_data"
    try:
        return of_folder(Path(next(iter(found.submodule_search_locations))), of)
    except ModelError:
        return made_here()


_in_use: list[Library] = []


def current() -> Library:
    """The library that scenes are made from: the innermost `using`, else `shipped`."""
    return _in_use[-1] if _in_use else shipped()


@contextmanager
def using(library: Library) -> Iterator[Library]:
    """Make scenes from this library within the block."""
    _in_use.append(library)
    try:
        yield library
    finally:
        _in_use.remove(library)
