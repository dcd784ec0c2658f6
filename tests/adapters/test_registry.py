"""Engines are found by name; what cannot be had is listed with the reason and raises only when asked for."""

import sys
from importlib import metadata

import pytest

from adapters import registry
from adapters.engine import checked_settings, defaults
from scenarios.catalogue import UnknownName

HOUSE = {"reference", "pybullet", "mujoco", "pymunk"}


@pytest.fixture
def plug_in(tmp_path):
    """Function text -> registers it as the source `acme`."""

    def write(text):
        path = tmp_path / "acme_adapter.py"
        path.write_text(text)
        registry.register("acme", str(path))
        return path

    yield write
    registry.unregister("acme")


WORKING = "name, version, effects, knobs = 'acme', '7', {}, {}\nvacuum = start = advance = read = lambda *a: None\n"


def test_the_house_registers_its_engines_as_third_parties_do():
    points = {point.name: point.value for point in metadata.entry_points(group=registry.GROUP)}
    assert set(points) >= HOUSE
    assert set(registry.sources()) >= HOUSE
    assert next(iter(registry.sources())) == "reference"


def test_an_engine_is_imported_when_asked_for(plug_in):
    plug_in(WORKING + "import sys; sys.acme_was_here = True\n")
    registry.sources()
    assert not hasattr(sys, "acme_was_here")
    engine = registry.engine("acme")
    assert (engine.name, engine.version) == ("acme", "7")
    assert sys.__dict__.pop("acme_was_here")


def test_engines_asked_for_by_name_are_all_that_is_imported(plug_in, toys):
    plug_in("import sys; sys.acme_was_here = True")
    assert registry.select(["toy", "toy:shy"]) == ("toy", "toy:shy")
    assert not hasattr(sys, "acme_was_here")
    registry.names()
    assert sys.__dict__.pop("acme_was_here")


def test_a_mapping_gives_several_engines(toys):
    assert registry.engine("toy:faulty") is toys["toy:faulty"]
    assert set(registry.select(["toy*"])) == {"toy", "toy:faulty", "toy:shy"}
    assert registry.select(["toy*", "!*:faulty"]) == ("toy", "toy:shy")
    assert registry.select(["*:shy"]) == ("toy:shy",)
    assert not set(registry.select(["!toy*"])) & set(toys)


def test_an_engine_whose_name_is_not_its_entry_points_is_found(plug_in):
    plug_in(WORKING.replace("'acme'", "'rocket'"))
    assert registry.engine("rocket").version == "7"


@pytest.mark.usefixtures("toys")
def test_an_unknown_name_lists_near_matches_and_all_names():
    with pytest.raises(UnknownName, match=r"no engine 'toy:shi'; did you mean toy:shy.*reference"):
        registry.engine("toy:shi")
    with pytest.raises(UnknownName, match=r"no engine 'bullet\*'"):
        registry.select(["bullet*"])
    with pytest.raises(UnknownName, match="no engine 'bullet'"):
        registry.select(["!bullet"])


def test_a_missing_library_is_not_installed_with_the_command_that_brings_it(plug_in):
    plug_in("import acme_physics.core\n")
    with pytest.raises(registry.NotInstalled, match="acme_physics is not installed; pip install acme_physics"):
        registry.engine("acme")
    row = next(row for row in registry.listings() if row.name == "acme")
    assert (row.state, row.install) == ("not-installed", "pip install acme_physics")
    assert "acme" in registry.select(["acme"])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("raise OSError('libacme.so: cannot open shared object file')", "OSError: libacme.so"),
        ("raise SystemExit('licence expired')", "SystemExit: licence expired"),
        ("1 / 0", "ZeroDivisionError"),
        ("name, version = 'acme', '1'", "it lacks effects, knobs, vacuum, start, advance, read"),
        (f"{WORKING}class E: pass\nE.__dict__\nENGINES = {{'acme:b': __import__('sys').modules[__name__]}}",
         "'acme:b' calls itself 'acme'"),
    ],
)  # fmt: skip
def test_a_broken_plug_in_is_listed_with_the_reason(plug_in, text, reason):
    plug_in(text)
    row = next(row for row in registry.listings() if row.name == "acme")
    assert row.state == "broken"
    assert reason in row.reason
    assert "\n" not in row.reason
    with pytest.raises(registry.Unavailable, match="acme"):
        registry.engine("acme")


def test_a_version_that_raises_does_not_break_the_list(plug_in):
    plug_in(
        "class Acme:\n    name, effects, knobs = 'acme', {}, {}\n    vacuum = start = advance = read = print\n"
        "    @property\n    def version(self): raise RuntimeError('no device')\nENGINES = {'acme': Acme()}\n"
    )
    row = next(row for row in registry.listings() if row.name == "acme")
    assert (row.state, row.reason) == ("broken", "RuntimeError: no device")


@pytest.mark.parametrize("module", ["pybullet", "mujoco", "pymunk"])
def test_install_lines_of_the_house_come_from_its_own_metadata(module):
    line = registry.install_line(module, "plumbline")
    assert line.startswith(f"pip install '{module}")
    assert ">=" in line


def test_install_lines_say_when_the_python_is_too_new(monkeypatch):
    monkeypatch.setattr(registry.sys, "version_info", (3, 13, 0))
    assert "for Python < 3.12 only; this is 3.13" in registry.install_line("pybullet", "plumbline")
    assert "Python" not in registry.install_line("pymunk", "plumbline")


def test_install_lines_of_strangers_name_the_module():
    assert registry.install_line("warp", "no-such-distribution") == "pip install warp"
    assert registry.install_line("warp", "") == "pip install warp"


def test_baselines_run_on_one_suite_unless_engines_are_named():
    assert registry.baselines() == {"reference:lecture": "smoke"}
    assert registry.baselines(["!pymunk*"]) == {"reference:lecture": "smoke"}
    assert registry.baselines(["!*:lecture"]) == {}
    assert registry.baselines(["reference*"]) == {}
    assert "reference:lecture" not in registry.select([])


def test_a_default_is_the_same_setting_whether_it_is_named_or_not():
    for name in registry.names():
        had = registry.engine(name)
        again = checked_settings(had, defaults(had))
        assert {k: repr(v) for k, v in again.items()} == {k: repr(v) for k, v in defaults(had).items()}
