"""A user's own files as scenarios: a scene in TOML, or Python functions decorated with `scenario`."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zlib import crc32

from mechanics.scene import Scene
from mechanics.scene_file import load_scene, scene_digest, scene_from_dict
from scenarios import catalogue
from scenarios.scenario import FAMILIES, Scenario

SUFFIXES = (".toml", ".py")
NO_SOURCE = "none: a scene of the user"


class BadFile(ValueError):
    """A file that holds no scenario; the message names it."""


def is_file(word: str) -> bool:
    """Whether the word means a file and not a suite."""
    return word.endswith(SUFFIXES)


def scene_scenario(scene: Scene, name: str, duration: float, sampling: float) -> Scenario:
    """Scenario without a truth: everything is measured, nothing is demanded.

    Its version is a checksum of what is asked, so that results of an earlier form of the scene are
    not taken for results of this one.
    """
    asked = f"{scene_digest(scene)} {duration!r} {sampling!r}"
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=sampling,
        checks=(),
        source=NO_SOURCE,
        about=tuple(sorted(scene.needs, key=lambda kind: kind.__name__)),
        name=name,
        version=crc32(asked.encode()),
        summary=f"The scene of {name}; its truth is not known, so nothing is demanded.",
        tags=("own",),
    )


def scenario_again(name: str, told: Mapping[str, Any]) -> Scenario | None:
    """The scenario of a scene file as the description in an archived run holds it; None if it was none of those."""
    if told.get("source") != NO_SOURCE or "scene" not in told:
        return None
    return scene_scenario(scene_from_dict(told["scene"]), name, told["duration"], told["sampling"])


def scenarios_of(
    path: str | Path, duration: float | None = None, sampling: float | None = None
) -> tuple[Scenario, ...]:
    """Scenarios of a file: one for a scene in TOML, every variant of every function for Python.

    Parameters
    ----------
    duration, sampling : float, optional
        Of a scene in TOML [s]; 2 s and a hundredth of the duration where they are not given.

    Raises
    ------
    SceneError
        For a scene that is not possible.
    BadFile
        If there is no such file, it cannot be imported, or it holds no scenario.
    """
    path = Path(path)
    if not path.is_file():
        raise BadFile(f"there is no file {path}")
    if path.suffix == ".toml":
        duration = 2.0 if duration is None else duration
        sampling = duration / 100.0 if sampling is None else sampling
        return (scene_scenario(load_scene(path), path.stem, duration, sampling),)
    if duration is not None or sampling is not None:
        raise BadFile(f"{path}: --duration and --sampling are for scenes in TOML; a scenario in Python says its own")
    with _blaming(path):
        with _own_families() as found:
            _import(path.resolve())
        chosen = tuple(s for family in found.values() for s in family.all())
    if not chosen:
        raise BadFile(f"{path} holds no scenario: decorate a function that returns a Scenario with @scenario(tags=...)")
    return chosen


@contextmanager
def _own_families() -> Iterator[dict]:
    """What enters the catalogue meanwhile, and leaves it again: a user's file does not change the house."""
    catalogue.families()  # a file that borrows from the house must find it imported, or would seem to bring it
    before = dict(FAMILIES)
    found: dict = {}
    FAMILIES.clear()
    try:
        yield found
        found |= FAMILIES
    finally:
        FAMILIES.clear()
        FAMILIES.update(before)


def _import(path: Path) -> None:
    name = f"plumbline_own_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)


@contextmanager
def _blaming(path: Path) -> Iterator[None]:
    """Whatever a user's code raises names its file and the line."""
    try:
        yield
    except (Exception, SystemExit) as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__)
                 if frame.filename == str(path.resolve())]  # fmt: skip
        where = f", line {lines[-1]}" if lines else ""
        raise BadFile(f"{path}{where}: {type(error).__name__}: {error}") from error
