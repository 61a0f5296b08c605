"""A serialised state of the first FMU, offered to the second, a version of the same unit."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import FATAL, STARTS, Fmu

first, second = (Fmu(path, sys.argv[1]).ready(STARTS["ship"]) for path in sys.argv[2:])
text = first.serialize(first.get_state())
assert first.set_state(first.deserialize(text)) == 0
status = second.set_state(second.deserialize(text))
assert "not a state of ship" in second.messages[-1][2]
print("refused" if status == FATAL else status)
