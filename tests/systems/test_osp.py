"""``OspSystemStructure.xml`` as a scene: values, functions, groups, and what a host of OSP does otherwise."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.systems.write import DEFINED
from tests.zoo.zoo import animal
from towage.errors import SceneError
from towage.master.master import run_resolved
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.scene import Scene

SPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
GROUPS = (
    '<OspModelDescription xmlns="https://open-simulation-platform.com/OspModelDescription/1.0.0" version="1.0"><VariableGroups>'
    '<Generic name="port"><Force name="in"><Variable ref="{0}"/></Force>'
    '<Generic name="out"><Variable ref="{1}"/></Generic></Generic>'
    "</VariableGroups></OspModelDescription>"
)


def simulator(name: str, source: str = "../fmus/a.fmu", **values: object) -> str:
    told = ""
    for variable, value in values.items():
        kind = {bool: "Boolean", int: "Integer", str: "String"}.get(type(value), "Real")
        told += f'<InitialValue variable="{variable}"><{kind} value="{str(value).lower()}"/></InitialValue>'
    return f'<Simulator name="{name}" source="{source}"><InitialValues>{told}</InitialValues></Simulator>'


def ends(tag: str, *places: str) -> str:
    """ "a.y", or "f():in" for a signal of a function."""
    kind = "VariableGroup" if "Group" in tag else "Variable"
    told = ""
    for place in places:
        function, signal, name = place.partition("():")
        unit, _, variable = place.partition(".")
        told += (
            f'<Signal function="{function}" name="{name}"/>'
            if signal
            else f'<{kind} simulator="{unit}" name="{variable}"/>'
        )
    return f"<{tag}>{told}</{tag}>"


def written(
    folder: Path, simulators: str, connections: str = "", functions: str = "", more: str = "", **about: object
) -> Path:
    """config/OspSystemStructure.xml, with the FMU in fmus/ beside it."""
    for name in ("config", "fmus"):
        (folder / name).mkdir(exist_ok=True)
    animal(folder / "fmus" / "a.fmu", **about)  # type: ignore[arg-type]
    path = folder / "config" / "OspSystemStructure.xml"
    path.write_text(
        f'<OspSystemStructure xmlns="{SPACE}" version="0.1"><StartTime>0.0</StartTime><EndTime>2</EndTime>'
        f"<BaseStepSize>0.1</BaseStepSize>{more}<Simulators>{simulators}</Simulators><Functions>{functions}</Functions>"
        f"<Connections>{connections}</Connections></OspSystemStructure>"
    )
    return path


def run(path: Path) -> Result:
    result = run_resolved(resolve(Scene.load(path).with_values({"coupling.error_estimate": False})))
    assert result.status == "done", result.message
    return result


def test_functions_and_initial_values(tmp_path: Path) -> None:
    """u2 = 2 y1 + 1 by a function, so that y2 = t^2 + t; connections are read in whatever order."""
    links = ends("SignalConnection", "b.u", "f():out") + ends("SignalConnection", "a.y", "f():in")
    links += ends("VariableConnection", "b.s_in", "a.s")
    function = '<LinearTransformation name="f" factor="2" offset="1"/>'
    path = written(tmp_path, simulator("a", u=1.0, s_in="word") + simulator("b", x0=3.0), links, function)
    result = run(path)
    assert result["b.y"][-1] == pytest.approx(9.0, rel=1e-12)  # sums of 20 steps in double precision
    assert result["b.s"][-1] == "word"
    scene = Scene.load(path.parent)
    assert (scene.file, scene.units["b"].parameters) == (path.parent.resolve(), {"x0": 3.0})


def test_groups_within_groups_are_connected_in_order(tmp_path: Path) -> None:
    links = ends("VariableGroupConnection", "a.port", "b.port")
    path = written(tmp_path, simulator("a", x0=2.0) + simulator("b"), links)
    (tmp_path / "fmus" / "zoo_OspModelDescription.xml").write_text(GROUPS.format("y", "u"))
    with pytest.raises(SceneError, match="both ends give values"):
        Scene.load(path)
    link = ends("VariableGroupConnection", "a.in", "b.out")
    path = written(tmp_path, simulator("a", x0=2.0) + simulator("b"), link)
    assert Scene.load(path).connections == ("a.y -> b.u",)


def test_numbers_pass_as_they_are(tmp_path: Path) -> None:
    """No host of OSP converts units of measure, which is said."""
    link = ends("VariableConnection", "a.y", "b.u")
    about = {"reals": {"y": ' unit="km"', "u": ' unit="m"'}, "extra": DEFINED}
    path = written(tmp_path, simulator("a", x0=2.0) + simulator("b"), link, **about)
    assert run(path)["b.w"][0] == 2.0
    assert "a.y [km] -> b.u [m]: the number passes unchanged" in Scene.load(path).notes[0].text


def test_what_a_scene_has_no_place_for_is_said(tmp_path: Path) -> None:
    proxy = simulator("a", "proxyfmu://localhost?file=../fmus/a.fmu").replace("name=", 'stepSize="0.2" name=', 1)
    path = written(tmp_path, proxy, more="<Algorithm>ecco</Algorithm><EccoConfiguration/><Colour/>")
    words = "\n".join(note.text for note in Scene.load(path).notes)
    for text in ("'ecco' is not one of", "EccoConfiguration is not read", "<Colour> is not understood", "not through proxy-fmu",
                 "a has a step of its own, 0.2 s"):  # fmt: skip
        assert text in words


@pytest.mark.parametrize(
    ("simulators", "connections", "functions", "message"),
    [
        (simulator("a", "proxyfmu://far?file=a.fmu"), "", "", "is not fetched from another machine"),
        (simulator("a", "http://far/a.fmu"), "", "", "is not fetched"),
        (simulator("a", "../fmus/b.fmu"), "", "", "no such file; did you mean 'a.fmu'"),
        (simulator("a", v=1.0), "", "", "initial value of a.v: its FMU has no such variable"),
        (simulator("a", x0="x").replace("String", "Real"), "", "", "'x' is no Real"),
        (simulator("a") * 2, "", "", "the name 'a' is taken"),
        (simulator("a"), ends("VariableConnection", "a.y", "b.u"), "", "there is no simulator 'b'"),
        (simulator("a"), ends("VariableConnection", "a.y", "a.w"), "", "both ends give values"),
        (simulator("a"), ends("VariableConnection", "a.y"), "", "a connection has two ends"),
        (simulator("a"), ends("SignalConnection", "a.y", "f():in"), "", "no function 'f' with a signal 'in'"),
        (simulator("a"), ends("VariableGroupConnection", "a.p", "a.q"), "", "'a' has no variable group 'p'"),
        (
            simulator("a"),
            "",
            '<Sum name="f" inputCount="2"/>',
            "function 'f': is a Sum, for which a scene has no place",
        ),
        (simulator("a"), "", '<LinearTransformation name="f" factor="x"/>', "'x' is no finite number"),
    ],
)
def test_what_is_refused(tmp_path: Path, simulators: str, connections: str, functions: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Scene.load(written(tmp_path, simulators, connections, functions))
