"""Scenes as data: TOML files, and the plain dictionaries behind them.

A scene file has one [[body]] table per body and one [[effect]] table per effect, with the fields of
`Body` and of the effects; shapes and effects are chosen by their `type`.  Nothing in it is executed.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from hashlib import blake2b
from pathlib import Path
from typing import Any

from mechanics.arrays import SceneError
from mechanics.effects import EFFECTS, Effect, PairEffect
from mechanics.scene import Body, Scene
from mechanics.shapes import SHAPES


def load_scene(path: str | Path) -> Scene:
    """Scene of a TOML file.

    Raises
    ------
    SceneError
        For a value that is not possible, with the file and the key path in front; for broken TOML,
        with line and column.
    OSError
        If the file cannot be read.
    """
    text = Path(path).read_text(encoding="utf-8")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(str(path), str(error), "valid TOML") from None
    try:
        return scene_from_dict(data)
    except SceneError as error:
        raise SceneError(f"{path}: {error.field}", error.value, error.allowed) from None


def scene_from_dict(data: Mapping[str, Any]) -> Scene:
    """Scene of a dictionary {"body": [...], "effect": [...]}, as a TOML file holds it.

    Raises
    ------
    SceneError
        With the key path of the offending value, for example ``body[1].mass``.
    """
    _known("", data, {"body", "effect"})
    bodies = [_at(f"body[{i}]", _body, table) for i, table in enumerate(_tables("body", data))]
    effects = [_at(f"effect[{i}]", _effect, table) for i, table in enumerate(_tables("effect", data))]
    return Scene(tuple(bodies), tuple(effects))


def scene_to_dict(scene: Scene) -> dict[str, Any]:
    """Dictionary that `scene_from_dict` turns into an equal scene; holds only what differs from the defaults."""
    return {
        "body": [_written(body) | {"shape": _typed(body.shape)} for body in scene.bodies],
        "effect": [_typed(effect) for effect in scene.effects],
    }


def scene_digest(scene: Scene) -> str:
    """Hash of everything the scene says: equal digests mean the same question."""
    text = json.dumps(scene_to_dict(scene), sort_keys=True)
    return blake2b(text.encode(), digest_size=16).hexdigest()


def _tables(key: str, data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    tables = data.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(t, Mapping) for t in tables):
        raise SceneError(key, tables, f"an array of tables: [[{key}]]")
    return tables


def _at(path: str, build: Any, table: Mapping[str, Any]) -> Any:
    """Build one item; its errors get the key path in front instead of the body's own name."""
    try:
        return build(table)
    except SceneError as error:
        own = f"body {table.get('name')!r}."
        raise SceneError(f"{path}.{error.field.removeprefix(own)}", error.value, error.allowed) from None


def _known(kind: str, table: Mapping[str, Any], names: set[str], required: set[str] = frozenset()) -> None:  # type: ignore[assignment]
    for key in table:
        if key not in names:
            raise SceneError(
                key, table[key], f"no such field{f' of {kind}' if kind else ''}; there are {sorted(names)}"
            )
    for key in sorted(required - set(table)):
        raise SceneError(key, None, f"{kind} needs it")


def _chosen(table: Mapping[str, Any], kinds: Mapping[str, type]) -> type:
    if table.get("type") not in kinds:
        raise SceneError("type", table.get("type"), f"one of {', '.join(kinds)}")
    return kinds[table["type"]]


def _filled(kind: type, table: Mapping[str, Any]) -> Any:
    own = {f.name for f in fields(kind)}
    required = {f.name for f in fields(kind) if f.default is MISSING and f.default_factory is MISSING}
    given = {key: value for key, value in table.items() if key != "type"}
    _known(kind.__name__, given, own, required)
    return kind(**given)


def _body(table: Mapping[str, Any]) -> Body:
    shape = table.get("shape")
    if not isinstance(shape, Mapping):
        raise SceneError("shape", shape, f"a table with a type, one of {', '.join(SHAPES)}")
    made = _at("shape", lambda t: _filled(_chosen(t, SHAPES), t), shape)
    return _filled(Body, {**table, "shape": made})


def _effect(table: Mapping[str, Any]) -> Effect:
    kind = _chosen(table, EFFECTS)
    if issubclass(kind, PairEffect) and "between" in table:
        table = {**table, "between": tuple(_exceptions(table["between"]))}
    return _filled(kind, table)


def _exceptions(rows: Any) -> Iterator[tuple[tuple[str, str], float]]:
    for n, row in enumerate(rows if isinstance(rows, list) else [rows]):
        if not isinstance(row, Mapping) or set(row) != {"a", "b", "coefficient"}:
            raise SceneError(f"between[{n}]", row, "a table with a, b and coefficient")
        yield (row["a"], row["b"]), row["coefficient"]


def _typed(value: Any) -> dict[str, Any]:
    return {"type": type(value).__name__} | _written(value)


def _written(value: Any) -> dict[str, Any]:
    out = {}
    for f in fields(value):
        item = getattr(value, f.name)
        if f.name == "shape" or (f.default is not MISSING and item == f.default) or item == math.inf:
            continue
        if f.name == "between":
            item = [{"a": a, "b": b, "coefficient": c} for (a, b), c in item]
        out[f.name] = _plain(item)
    return out


def _plain(value: Any) -> Any:
    return [_plain(v) for v in value] if isinstance(value, tuple) else value
