"""FMUs that are sound but for one thing, which must be noticed before anything of them is unpacked or run."""

from __future__ import annotations

import platform
import struct
import zipfile
from pathlib import Path

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Box" guid="{{1-2}}" generationTool="by hand" {root}>
  <CoSimulation modelIdentifier="box" canGetAndSetFMUstate="true" canSerializeFMUstate="1"
    canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true" maxOutputDerivativeOrder="2"/>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1"/></Unit><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
    <Unit name="bare"/>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Depth"><Real unit="m" displayUnit="ft" min="-10" max="0" nominal="5"/></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="10" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="force" valueReference="0" causality="input" description="Force"><Real start="0" unit="N"/>
    </ScalarVariable>
    <ScalarVariable name="depth" valueReference="1" causality="output"><Real declaredType="Depth" max="1"/>
    </ScalarVariable>
    <ScalarVariable name="count" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="on" valueReference="2" causality="parameter" variability="fixed"><Boolean start="true"/>
    </ScalarVariable>
    <ScalarVariable name="label" valueReference="3" causality="parameter" variability="tunable"><String start=" a "/>
    </ScalarVariable>
    <ScalarVariable name="pull" valueReference="4" causality="output"><Real/></ScalarVariable>
    {variables}
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies=""/><Unknown index="3"/><Unknown index="6" dependencies="1 4"/>
  </Outputs></ModelStructure>
</fmiModelDescription>
"""
MACHINE = 183 if platform.machine().lower() in ("arm64", "aarch64") else 62


def xml(root: str = "", variables: str = "") -> str:
    return DESCRIPTION.format(root=root, variables=variables)


def elf(machine: int = MACHINE, kind: int = 3, size: int = 512) -> bytes:
    """The smallest shared object as far as its headers go: one loadable segment over the whole file."""
    head = b"\x7fELF\x02\x01\x01".ljust(16, b"\0")
    head += struct.pack("<HHIQQQIHHHHHH", kind, machine, 1, 0, 64, 0, 0, 64, 56, 1, 64, 0, 0)
    return (head + struct.pack("<IIQQQQQQ", 1, 5, 0, 0, 0, size, size, 4096)).ljust(size, b"\0")


def build(path: Path, description: str | bytes | None = None, library: bytes | None = None, **more: bytes) -> Path:
    """An FMU; ``more`` are further entries, '/' spelled '__'."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as fmu:
        fmu.writestr("modelDescription.xml", xml() if description is None else description)
        fmu.writestr("binaries/linux64/box.so", elf() if library is None else library)
        for name, data in more.items():
            fmu.writestr(name.replace("__", "/"), data)
    return path


def with_entry(path: Path, *entries: zipfile.ZipInfo | str) -> Path:
    """A sound FMU to which entries of these names are added as they are, each with a content of its own."""
    build(path)
    with zipfile.ZipFile(path, "a") as fmu:
        for k, entry in enumerate(entries):
            fmu.writestr(entry, b"x" * (1 + k % 2))
    return path


def declare_size(path: Path, name: bytes, size: int) -> None:
    """Falsify the unpacked size of the entry in the archive's directory."""
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.rindex(name) - 46 + 24, size)
    path.write_bytes(data)


DOCTYPE = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>'


HOSTILE_NAMES = [
    ("../evil", "leaves"),
    ("resources/../../evil", "leaves"),
    ("/etc/evil", "absolute"),
    ("C:/evil", "absolute"),
    ("c:evil", "absolute"),
    ("..\\evil", "portable"),
    ("resources/a:b", "portable"),
    ("resources/./a", "portable"),
    ("resources//a", "portable"),
    ("resources/nul\x01", "portable"),

    ("MODELDESCRIPTION.xml", "collides"),
    ("Binaries/win64/box.dll", "collides"),
    ("modelDescription.xml/a", "collides"),
]
CO_SIMULATION = xml()[xml().index("<CoSimulation") : xml().index("<UnitDefinitions")]
EXTRA = '<ScalarVariable name="extra" valueReference="9" {}'
INVALID_DESCRIPTIONS = [
    ("", "well-formed"),
    ("<a><b></a>", "well-formed"),
    (xml()[:-30], "well-formed"),
    (xml().replace("UTF-8", "martian"), "well-formed"),
    (xml() + "<more/>", "well-formed"),
    ("<other/>", "expected 'fmiModelDescription'"),
    (xml().replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "FMI version '1.0' is not supported"),
    (xml().replace('fmiVersion="2.0"', 'fmiVersion="3.0"'), "required attribute 'instantiationToken' is missing"),
    (xml().replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "FMI version '1.0' is not supported"),
    (xml().replace(CO_SIMULATION, '<ModelExchange modelIdentifier="box"/>'), "model exchange, which is not supported"),
    (xml().replace('"box"', '"../../box"'), "not a C identifier"),
    (xml().replace('modelName="Box"', ""), "'modelName' is missing"),
    (xml().replace('guid="{1-2}"', ""), "'guid' is missing"),
    (xml().replace('Order="2"', 'Order="two"'), "maxOutputDerivativeOrder='two', expected int"),
    (xml().replace('state="1"', 'state="yes"'), "canSerializeFMUstate='yes', expected boolean"),
    (xml().replace('offset="273.15"', 'factor="0"'), "'degC' has factor 0"),
    (xml(variables=EXTRA.format("><Real/></ScalarVariable>").replace("extra", "depth")), "'depth' is declared twice"),
    (xml(variables=EXTRA.format("/>")), "exactly one type"),
    (xml(variables=EXTRA.format("><Real/><Integer/></ScalarVariable>")), "exactly one type"),
    (xml(variables=EXTRA.format("><Real/></ScalarVariable>").replace('"9"', '"-1"')), "value reference"),
    (xml(variables=EXTRA.format("><Real/></ScalarVariable>").replace('"9"', '"x"')), "'extra': .*valueReference='x'"),
    (xml(variables=EXTRA.format('causality="boss"><Real/></ScalarVariable>')), "causality 'boss', expected parameter"),
    (xml(variables=EXTRA.format('variability="odd"><Real/></ScalarVariable>')), "variability 'odd', expected constant"),
    (xml(variables=EXTRA.format('><Real start="x"/></ScalarVariable>')), "start='x', expected float"),
    (xml(variables=EXTRA.format('><Integer start="1.5"/></ScalarVariable>')), "start='1.5', expected int"),
    (xml(variables=EXTRA.format('><Integer declaredType="Depth"/></ScalarVariable>')), "declaredType 'Depth'"),
    (xml().replace('index="2"', 'index="7"'), "names variable '7', expected 1 to 6"),
    (xml().replace('index="2"', 'index="0"'), "names variable '0'"),
    (xml().replace('index="2"', 'index="1"'), "lists 'force' as an output"),
    (xml().replace('"1 4"', '"1 x"'), "names variable 'x'"),
]
BROKEN_LIBRARIES = [
    (b"", "no ELF header"),
    (b"MZ" + bytes(500), "no ELF header"),
    (elf()[:40], "truncated header"),
    (elf()[:100], "header tables lie beyond"),
    (elf()[:300], "a segment ends beyond"),
    (elf(machine=8), "another processor"),
    (elf(kind=2), "no shared object"),
    (b"\x7fELF\x01" + elf()[5:], "not 64-bit little-endian"),
    (b"\x7fELF\x02\x02" + elf()[6:], "not 64-bit little-endian"),
    (elf()[:40] + struct.pack("<Q", 2**63) + elf()[48:], "header tables lie beyond"),
]
