"""The engines that ship with the harness, by name, and how to load one's own."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType, ModuleType

from oracles.engine import FILES, Engine, EngineUnavailable

SHIPPED: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "fcl": ("oracles.engines.fcl_engine:FclEngine", "fcl"),
        "bullet": ("oracles.engines.bullet_engine:BulletEngine", "pybullet"),
        "pybullet-defaults": ("oracles.engines.bullet_defaults:BulletDefaults", "pybullet"),
        "bullet-stepping": ("oracles.engines.bullet_stepping:BulletStepping", "pybullet"),
        "bullet-ccd": ("oracles.engines.bullet_stepping:BulletSwept", "pybullet"),
        "pymunk": ("oracles.engines.pymunk_engine:PymunkEngine", "pymunk"),
    }
)
"""Name to (adapter, the module that the engine's package installs)."""


def available_engines() -> dict[str, str | None]:
    """Every shipped engine, and why it cannot be used here, or None; nothing is imported to find out."""
    return {name: _missing(name) for name in SHIPPED}


def load_engine(spec: str) -> Engine:
    """Make an engine from its name, from ``module:attribute`` or from ``path/to/file.py:attribute``.

    The attribute is an `Engine`, or a class or function without arguments that makes one.

    Raises
    ------
    EngineUnavailable
        When there is no such engine, or its package is not installed.
    """
    if spec in SHIPPED:
        missing = _missing(spec)
        if missing:
            raise EngineUnavailable(missing)
        spec = SHIPPED[spec][0]
    source, colon, attribute = spec.rpartition(":")
    if not (colon and source and attribute):
        known = ", ".join(SHIPPED)
        raise EngineUnavailable(f"no engine {spec!r}: there are {known}, or name one's own as module:attribute")
    made = _attribute(_module(source, spec), attribute, spec)
    engine = made() if callable(made) else made
    if not isinstance(engine, Engine):
        raise EngineUnavailable(f"{spec} is no engine: it gives a {type(engine).__name__}")
    return engine


PACKAGES: Mapping[str, str] = MappingProxyType(
    {name: {"fcl": "python-fcl"}.get(module, module) for name, (_, module) in SHIPPED.items()}
)
"""Name to the package that the index knows."""
EXTRAS: Mapping[str, str] = MappingProxyType(
    {name: {"pybullet": "bullet"}.get(module, module) for name, (_, module) in SHIPPED.items()}
)
"""Name to the extra of this project that installs it."""


def _missing(name: str) -> str | None:
    module = SHIPPED[name][1]
    if importlib.util.find_spec(module) is not None:
        return None
    package = f"pip install {PACKAGES[name]} (the extra {EXTRAS[name]!r})"
    return f"the engine {name!r} needs the module {module}, which is not installed: {package}"


def _module(source: str, spec: str) -> ModuleType:
    if source.endswith(".py"):
        return _module_of_file(Path(source), spec)
    try:
        return importlib.import_module(source)
    except ImportError as error:
        raise EngineUnavailable(f"{spec} cannot be imported: {error}") from error


def _module_of_file(path: Path, spec: str) -> ModuleType:
    """Import a file under a name of its own, once."""
    name = f"{path.stem}_{sha256(str(path.resolve()).encode()).hexdigest()[:8]}"
    if name in sys.modules:
        return sys.modules[name]
    found = importlib.util.spec_from_file_location(name, path)
    if found is None or found.loader is None or not path.is_file():
        raise EngineUnavailable(f"{spec} cannot be imported: there is no file {path}")
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module
    if path.stem.isidentifier():
        FILES[name] = path.stem
    try:
        found.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _attribute(module: ModuleType, attribute: str, spec: str) -> object:
    try:
        return getattr(module, attribute)
    except AttributeError:
        raise EngineUnavailable(f"{spec}: the module has no {attribute}") from None
