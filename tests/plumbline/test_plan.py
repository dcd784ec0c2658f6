"""What is asked for is what is planned; what is not there is named with what is."""

import json
import shlex

import pytest

from comparisons.cell import cell_key
from plumbline import plan
from plumbline.cli import main
from scenarios import catalogue
from scenarios.catalogue import UnknownName


def names(chosen):
    return [s.name for s in chosen]


def test_a_suite_is_the_suite_of_the_catalogue():
    assert names(plan.choose("smoke")) == names(catalogue.suite("smoke"))


def test_without_a_suite_selectors_choose_from_the_whole_catalogue():
    assert names(plan.choose(selectors=["free-fall"])) == names(catalogue.find("free-fall"))
    both = names(plan.choose(selectors=["free-fall", "proj*", "free-fall"]))
    assert both == names(catalogue.find("free-fall")) + names(catalogue.find("projectile"))


def test_with_a_suite_selectors_choose_among_its_scenarios():
    smoke = names(catalogue.suite("smoke"))
    assert names(plan.choose("smoke", ["bouncing-ball"])) == ["bouncing-ball"]
    assert len(plan.choose("standard", ["bouncing-ball"])) > 1
    assert names(plan.choose("smoke", ["!bouncing-ball"])) == [n for n in smoke if n != "bouncing-ball"]
    assert plan.choose("smoke", ["projectile"]) == ()


def test_parameters_choose_one_scenario_in_the_suite_or_not():
    assert names(plan.choose("smoke", ["bouncing-ball[e=0.45]"])) == ["bouncing-ball[e=0.45]"]


def test_tags_narrow_and_bar():
    impacts = plan.choose("standard", tags=["impact"])
    assert impacts
    assert all("impact" in s.tags for s in impacts)
    rest = plan.choose("standard", tags=["!impact"])
    assert sorted(names(impacts) + names(rest)) == sorted(names(catalogue.suite("standard")))


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"what": "smok"}, "no suite 'smok'; did you mean smoke"),
        ({"selectors": ["bouncing-bal"]}, "no scenario 'bouncing-bal'; did you mean bouncing-ball"),
        ({"selectors": ["!bouncing-bal"]}, "no scenario 'bouncing-bal'"),
        ({"what": "smoke", "tags": ["inpact"]}, "no tag 'inpact'; did you mean impact"),
        ({"what": "nowhere.toml"}, "there is no file nowhere.toml"),
    ],
)
def test_names_that_are_not_there_list_what_is(asked, message):
    with pytest.raises(ValueError, match=message):
        plan.choose(**asked)


@pytest.mark.parametrize("selector", ["bouncing-ball[e=2]", "bouncing-ball[bounce=1]", "bouncing-ball[e]"])
def test_impossible_parameters_are_refused(selector):
    with pytest.raises(ValueError, match="bouncing-ball"):
        plan.choose(selectors=[selector])


def test_settings_of_the_command_line():
    read = plan.read_settings(["dt=1e-3", "dt=0.01", "mujoco.integrator=Euler"])
    assert read == {"dt": [1e-3, 0.01], "mujoco.integrator": ["Euler"]}
    for bad in ("dt", "=1", "dt=", ""):
        with pytest.raises(ValueError, match="knob=value"):
            plan.read_settings([bad])


def test_every_combination_of_settings_is_a_cell(toys):
    chosen = plan.settings_of(toys["toy:faulty"], {"dt": [0.1, 0.05], "toy:*.fault": ["none", "nan"]})
    assert len(chosen) == 4
    assert {"dt": 0.05, "fault": "nan"} in chosen
    assert plan.settings_of(toys["toy"], {"toy:*.dt": 0.1}) == ({"dt": 0.05},)
    assert plan.settings_of(toys["toy"], {"fault": "nan"}) == ({"dt": 0.05},)


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"tempo": 1.0}, "no knob 'tempo'.*dt, fault"), ({"rocket.dt": 1.0}, "no engine in this run for --set 'rocket'"),
     ({"toy.fault": "nan"}, "toy has no knob 'fault'"), ({"dt": -1.0}, "a finite number > 0"),
     ({"fault": "flood"}, "allowed: none")],
)  # fmt: skip
def test_settings_that_are_about_nothing_are_refused(toys, settings, message):
    with pytest.raises(ValueError, match=message):
        plan.plan(catalogue.find("projectile"), list(toys), settings)


def test_a_job_is_keyed_by_what_identifies_it(toys):
    jobs = plan.plan(catalogue.find("free-fall"), ["toy", "toy:shy"], {"dt": [0.1, 0.05]})
    assert len({job.key for job in jobs}) == len(jobs) == 8
    for job in jobs:
        assert job.key == cell_key(job.scenario.name, job.scenario.version, job.engine, "1.2.3", job.settings)


def test_the_same_cell_asked_twice_is_one_job(toys):
    scenario = catalogue.find("projectile")
    assert len(plan.plan(scenario + scenario, ["toy"], {"dt": [0.1, 0.1]})) == 1


@pytest.mark.usefixtures("toys")
def test_the_command_of_every_cell_brings_exactly_that_cell(capsys):
    jobs = plan.plan(plan.choose(), ["toy:faulty"], {"dt": [0.1, 0.05], "fault": ["none", "nan"]})
    assert len(jobs) > 50
    for job in jobs[::7]:
        words = shlex.split(job.reproduce)
        assert words[0] == "plumbline"
        assert main([*words[1:], "--dry-run", "--json"]) == 0
        assert [row["key"] for row in json.loads(capsys.readouterr().out)] == [job.key]


def test_an_engine_that_cannot_be_had_is_planned_with_its_reason(tmp_path):
    from adapters import registry

    (tmp_path / "ghost.py").write_text("import no_such_physics")
    registry.register("ghost", str(tmp_path / "ghost.py"))
    try:
        (job,) = plan.plan(catalogue.find("projectile"), registry.select(["ghost"]))
    finally:
        registry.unregister("ghost")
    assert "pip install no_such_physics" in job.absent.reason
    assert plan.described_engines([job])["ghost"]["absent"] == job.absent.reason


def test_a_description_holds_what_a_reader_needs():
    told = plan.described(catalogue.find("projectile"))["projectile"]
    assert json.loads(json.dumps(told))["effects"] == ["Gravity"]
    assert {"quantity", "tolerance", "why", "exact"} == set(told["checks"][0])


def test_unknown_names_are_value_errors():
    assert issubclass(UnknownName, ValueError)


def test_a_baseline_runs_on_the_scenarios_of_its_suite_only():
    scenarios = (*catalogue.find("bouncing-ball"), *catalogue.find("incline[]"))
    jobs = plan.plan(scenarios, ["reference"], baselines={"reference:lecture": "smoke"})
    told = {(job.scenario.name, job.engine) for job in jobs}
    smoke = {s.name for s in catalogue.suite("smoke")}
    beside = {scenario for scenario, engine in told if engine == "reference:lecture"}
    assert beside == smoke & {s.name for s in scenarios} != set()
    assert {scenario for scenario, engine in told if engine == "reference"} == {s.name for s in scenarios}
    none = plan.plan(catalogue.find("incline[]"), ["reference"], baselines={"reference:lecture": "smoke"})
    assert {job.engine for job in none} == {"reference"}
