"""A serialised state of one FMU, offered to another version of the same unit. Arguments: directory to unpack to, pairs of
FMUs; prints what became of each pair."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import OK, Fmu

work, *paths = sys.argv[1:]
for pair in zip(paths[::2], paths[1::2]):
    first, second = (fmu.ready(fmu.start) for fmu in (Fmu(path, work) for path in pair))
    text = first.serialize(first.get_state())
    assert first.set_state(first.deserialize(text)) == OK
    assert second.set_state_of(text) == second.fmu.refusal
    assert f"not a state of {second.fmu.name}" in second.messages[-1][2]
    print("refused")
