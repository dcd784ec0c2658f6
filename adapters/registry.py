"""Engines by name.

Engines come from entry points of the group ``plumbline.engines`` and from `register`.  Each names a
target, ``module:attribute``, ``module`` or a ``.py`` file: a mapping name -> engine, or one engine.
A target is imported when one of its engines is asked for.  What cannot be imported is listed with
the reason and never raises on listing.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
import sys
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from importlib import metadata
from pathlib import Path
from typing import Any

from adapters.engine import Engine, on_request, sample
from scenarios.catalogue import unknown

GROUP = "plumbline.engines"
NAMES_OF_AN_ENGINE = ("name", "version", "effects", "knobs", "vacuum", "start", "advance", "read")


class Unavailable(Exception):
    """An engine that is registered but cannot be had here.  `reason` is one line."""

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason
        super().__init__(f"engine {name!r}: {reason}")


class NotInstalled(Unavailable):
    """The library an engine needs is missing; `install` is the command that brings it."""

    def __init__(self, name: str, module: str, install: str) -> None:
        self.module, self.install = module, install
        super().__init__(name, f"{module} is not installed; {install}")


@dataclass(frozen=True)
class Source:
    """Where engines come from.

    Attributes
    ----------
    name : str
        Name of the entry point.
    target : str
        ``module:attribute``, ``module``, or the path of a ``.py`` file.
    distribution : str
        The installed package that registers it; "" for `register`.
    """

    name: str
    target: str
    distribution: str = ""


@dataclass(frozen=True)
class Listing:
    """One line of the list of engines.

    Attributes
    ----------
    name, version : str
    state : str
        "installed", "not-installed" or "broken".
    reason : str
        Why not, in one line; "" if installed.
    install : str
        The command that installs what is missing, where that is the matter.
    source : Source
    """

    name: str
    version: str
    state: str
    reason: str
    install: str
    source: Source


_registered: dict[str, Source] = {}


def register(name: str, target: str) -> None:
    """Make the engines of `target` known in this process, without an installed package."""
    if target.endswith(".py"):
        target = str(Path(target).resolve())
    _registered[name] = Source(name, target)


def unregister(name: str) -> None:
    """Forget what `register` was told about `name`."""
    _registered.pop(name, None)


def sources() -> dict[str, Source]:
    """Where engines come from, by name: the reference first, then in alphabetical order."""
    found = {}
    for point in metadata.entry_points(group=GROUP):
        found[point.name] = Source(point.name, point.value, point.dist.name if point.dist else "")
    found |= _registered
    return dict(sorted(found.items(), key=lambda item: (item[0] != "reference", item[0])))


def load(target: str) -> dict[str, Engine]:
    """Engines of a target by name.

    Raises
    ------
    ImportError
        If it cannot be imported.
    TypeError
        If what it names is no engine, saying what is missing.
    """
    if target.endswith(".py"):
        found: Any = _load_file(Path(target))
        found = getattr(found, "ENGINES", found)
    else:
        module, _, attribute = target.partition(":")
        found = importlib.import_module(module)
        for part in filter(None, attribute.split(".")):
            found = getattr(found, part)
    engines = dict(found) if isinstance(found, Mapping) else {getattr(found, "name", target): found}
    for name, engine in engines.items():
        missing = [part for part in NAMES_OF_AN_ENGINE if not hasattr(engine, part)]
        if missing:
            raise TypeError(f"{target}: {name!r} is no engine: it lacks {', '.join(missing)}")
        if engine.name != name:
            raise TypeError(f"{target}: the engine listed as {name!r} calls itself {engine.name!r}")
    return engines


def engines_of(source: Source) -> dict[str, Engine]:
    """Engines of a source by name, imported now.

    Raises
    ------
    Unavailable
        NotInstalled if a library is missing, otherwise with the last line of whatever the import raised.
    """
    try:
        return load(source.target)
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if not missing or missing == re.split(r"[.:]", source.target)[0]:
            raise Unavailable(source.name, str(error)) from error
        raise NotInstalled(source.name, missing, install_line(missing, source.distribution)) from error
    except (Exception, SystemExit) as error:
        lines = f"{type(error).__name__}: {error}".strip().splitlines()
        raise Unavailable(source.name, lines[-1]) from error


def engine(name: str) -> Engine:
    """The engine of that name.

    Raises
    ------
    Unavailable
        If it is registered but cannot be had here (NotInstalled with the command that installs it).
    UnknownName
        If there is none; names near matches and all there are.
    """
    return engines_of(source_of(name))[name]


def source_of(name: str) -> Source:
    """Where the engine of that name comes from; its target has been imported.

    Raises
    ------
    Unavailable, UnknownName
        As `engine`.
    """
    known = sources()
    likely = known.get(name) or known.get(name.partition(":")[0])
    if likely and name in engines_of(likely):
        return likely
    for source in known.values():
        if source is not likely and name in _engines_or_none(source):
            return source
    raise unknown("engine", name, names())


def listings(only: Container[str] | None = None) -> tuple[Listing, ...]:
    """Every engine there is, and every source that cannot be had with the reason; never raises.

    Parameters
    ----------
    only : container of str, optional
        Names of the sources to look at; the others are not imported.
    """
    rows: list[Listing] = []
    for source in sources().values():
        if only is not None and source.name not in only:
            continue
        try:
            found = engines_of(source)
            rows += [Listing(name, str(e.version), "installed", "", "", source) for name, e in found.items()]
        except NotInstalled as error:
            rows.append(Listing(source.name, "", "not-installed", error.reason, error.install, source))
        except Unavailable as error:
            rows.append(Listing(source.name, "", "broken", error.reason, "", source))
        except Exception as error:  # a third party's `version` may be a property that raises
            reason = f"{type(error).__name__}: {error}".splitlines()[-1]
            rows.append(Listing(source.name, "", "broken", reason, "", source))
    return tuple(rows)


def names() -> tuple[str, ...]:
    """Names of all engines, installed or not."""
    return tuple(row.name for row in listings())


def select(patterns: Sequence[str] = ()) -> tuple[str, ...]:
    """Engine names that match any of the patterns and none of those that begin with ``!``.

    Patterns are names or globs such as ``reference*`` and ``*:stock``; order is that of `names`.
    Without a pattern to match: all but the engines that run on request only.

    Raises
    ------
    UnknownName
        For a pattern that matches nothing.
    """
    known = _likely(patterns) or names()
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern.removeprefix("!")) for name in known):
            raise unknown("engine", pattern.removeprefix("!"), known)
    wanted = [p for p in patterns if not p.startswith("!")]
    barred = [p.removeprefix("!") for p in patterns if p.startswith("!")]
    return tuple(
        name
        for name in known
        if (any(fnmatchcase(name, p) for p in wanted) if wanted else not _on_request(name))
        and not any(fnmatchcase(name, p) for p in barred)
    )


def baselines(patterns: Sequence[str] = ()) -> dict[str, str]:
    """Engines that run on request, but without it on one suite: their names and that suite's.

    None if `patterns` say which engines are to run; a pattern with ``!`` in front leaves out.
    """
    if any(not p.startswith("!") for p in patterns):
        return {}
    barred = [p.removeprefix("!") for p in patterns]
    found = {}
    for name in names():
        if _on_request(name) and not any(fnmatchcase(name, p) for p in barred) and (suite := sample(engine(name))):
            found[name] = suite
    return found


def _on_request(name: str) -> bool:
    """Whether an engine runs only when it is asked for; one that cannot be had is shown, not hidden."""
    try:
        return on_request(engine(name))
    except Unavailable:
        return False


def _likely(patterns: Sequence[str]) -> tuple[str, ...]:
    """Names of the engines of just the sources the patterns name, if they name engines plainly; else nothing."""
    if not patterns or any(set("*?[!") & set(pattern) for pattern in patterns):
        return ()
    known = tuple(row.name for row in listings({part for p in patterns for part in (p, p.partition(":")[0])}))
    return known if set(patterns) <= set(known) else ()


def install_line(module: str, distribution: str) -> str:
    """The pip command that brings `module`, as the metadata of the `distribution` that asks for it says."""
    try:
        requirements = metadata.requires(distribution) or [] if distribution else []
    except metadata.PackageNotFoundError:
        requirements = []
    for requirement in requirements:
        specification, _, marker = requirement.partition(";")
        package = re.split(r"[^A-Za-z0-9._-]", specification.strip())[0].lower().replace("_", "-")
        if package == module.lower() or package.startswith(f"{module.lower()}-"):
            return f"pip install '{specification.strip()}'{_python_limit(marker)}"
    return f"pip install {module}"


def _python_limit(marker: str) -> str:
    """A remark if the requirement is for older Pythons only than the one that runs."""
    limit = re.search(r"python_version\s*<\s*['\"](\d+)\.(\d+)['\"]", marker)
    if limit and sys.version_info[:2] >= (int(limit[1]), int(limit[2])):
        return f" (for Python < {limit[1]}.{limit[2]} only; this is {sys.version_info[0]}.{sys.version_info[1]})"
    return ""


def _engines_or_none(source: Source) -> dict[str, Engine]:
    try:
        return engines_of(source)
    except Unavailable:
        return {}


def _load_file(path: Path) -> Any:
    """Module of a file, once; its folder is not put on the import path."""
    name = f"plumbline_plugin_{path.stem}"
    known = sys.modules.get(name)
    if known is not None and getattr(known, "__file__", None) == str(path):
        return known
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
