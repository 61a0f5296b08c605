"""Systems of SSP and OSP for `tests.faults.doors`: two boxes (`tests.faults.boxes`) joined in every way that is read."""

from __future__ import annotations

import zipfile
from pathlib import Path

from tests.faults import boxes

_SET = (
    '<ssv:ParameterSet version="1.0" name="p"><ssv:Parameters><ssv:Parameter name="{0}on"><ssv:Boolean value="false"/>'
    '</ssv:Parameter><ssv:Parameter name="{0}force"><ssv:Real value="2" unit="kN"/></ssv:Parameter></ssv:Parameters>{1}'
    "</ssv:ParameterSet>"
)
_UNITS = '<x:Units><ssc:Unit name="kN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="1e3" offset="0"/></ssc:Unit></x:Units>'
_MAP = (
    '<ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="b.force" target="sub.b.force" suppressUnitConversion="false">'
    '<ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry></ssm:ParameterMapping>'
)
_BOX = (
    '<ssd:Component name="{0}" source="box.fmu" type="application/x-fmu-sharedlibrary" implementation="any"><ssd:Connectors>'
    '<ssd:Connector name="force" kind="input"><ssc:Real unit="kN"/></ssd:Connector><ssd:Connector name="pull" kind="output">'
    "<ssc:Real/></ssd:Connector></ssd:Connectors>{1}</ssd:Component>"
)
_LINK = '<ssd:Connection startElement="{}" startConnector="{}" endElement="{}" endConnector="{}">{}</ssd:Connection>'
_BIND = "<ssd:ParameterBindings><ssd:ParameterBinding prefix='{}'><ssd:ParameterValues>{}</ssd:ParameterValues>{}"
_BIND += "</ssd:ParameterBinding></ssd:ParameterBindings>"
_BUS = (
    '<ssd:SignalDictionaryReference name="bus" dictionary="d"><ssd:Connectors><ssd:Connector name="p" kind="inout"/>'
    "</ssd:Connectors></ssd:SignalDictionaryReference>"
)
_SUB = (
    '<ssd:System name="sub" id="sub"><ssd:Connectors><ssd:Connector name="in" kind="input"><ssc:Real unit="kN"/></ssd:Connector>'
    f"</ssd:Connectors><ssd:Elements>{_BOX.format('b', '')}</ssd:Elements><ssd:Connections>"
    '<ssd:Connection startConnector="in" endElement="b" endConnector="force"/></ssd:Connections></ssd:System>'
)
SSD = (
    '<?xml version="1.0"?><ssd:SystemStructureDescription version="1.0" name="seed"><ssd:System name="s"><ssd:Elements>'
    + _BOX.format("a", _BIND.format("", _SET.format("", _UNITS), ""))
    + _SUB
    + _BUS
    + '<ssd:Component name="again" source="#sub"/></ssd:Elements><ssd:Connections>'
    + _LINK.format("a", "pull", "bus", "p", '<ssc:LinearTransformation factor="2" offset="1"/>')
    + _LINK.format("again", "in", "bus", "p", "")
    + "</ssd:Connections><ssd:SignalDictionaries><ssd:SignalDictionary name='d'/></ssd:SignalDictionaries>"
    + _BIND.format("", _SET.format("b.", _UNITS), f"<ssd:ParameterMapping>{_MAP}</ssd:ParameterMapping>")
    + "</ssd:System>" + _UNITS
    + '<ssd:DefaultExperiment startTime="0" stopTime="10"><ssd:Annotations><ssc:Annotation type="a"><o:Algorithm>'
    '<o:FixedStepAlgorithm baseStepSize="0.1"/></o:Algorithm></ssc:Annotation></ssd:Annotations></ssd:DefaultExperiment>'
    "</ssd:SystemStructureDescription>"
)  # fmt: skip
OSP = (
    '<?xml version="1.0"?><OspSystemStructure version="0.1"><StartTime>0.0</StartTime><EndTime>10</EndTime>'
    "<BaseStepSize>0.1</BaseStepSize><Algorithm>fixedStep</Algorithm><Simulators>"
    '<Simulator name="a" source="box.fmu" stepSize="0.1"><InitialValues><InitialValue variable="on"><Boolean value="true"/>'
    '</InitialValue></InitialValues></Simulator><Simulator name="b" source="proxyfmu://localhost?file=box.fmu"/></Simulators>'
    '<Functions><LinearTransformation name="f" factor="2" offset="1"/></Functions><Connections>'
    '<SignalConnection><Variable simulator="a" name="pull"/><Signal function="f" name="in"/></SignalConnection>'
    '<SignalConnection><Signal function="f" name="out"/><Variable simulator="b" name="force"/></SignalConnection>'
    "</Connections></OspSystemStructure>"
)


def archive(path: Path) -> bytes:
    """The same system as an archive with a variant."""
    box = boxes.build(path.with_suffix(".fmu")).read_bytes()
    with zipfile.ZipFile(path, "w") as out:
        for name, content in {"SystemStructure.ssd": SSD, "Other.ssd": SSD, "box.fmu": box}.items():
            out.writestr(name, content)
    return path.read_bytes()
