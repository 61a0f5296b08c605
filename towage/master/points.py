"""What units that know nothing of towage need at a communication point: texts passed on, feedthrough up to date, events."""

from __future__ import annotations

from towage.master.system import ROUNDING, System


def look_after(system: System, time: float) -> None:
    """Before the point is recorded: `settle`, and texts, which are held over a step, passed on."""
    if system.late:
        settle(system, time)
    system.pass_texts()


def settle(system: System, time: float) -> None:
    """Read units again with the ends of the inputs that were held at their mean over the step: what goes straight through to an
    output that is only recorded is right at the communication point."""
    for i in system.late:
        unit, moved = system.units[i], False
        before = unit.values
        for s in system.into[i]:
            if not s.input.orders:
                moved = moved or abs(unit.input_buffer[s.input.slot] - s.value) > ROUNDING * s.scale
                unit.input_buffer[s.input.slot] = s.value
        unit.set(time)
        unit.get(time)
        system.read(i)
        if moved and unit.values == before:
            system.late_units.add(unit.name)


def changed(system: System, time: float) -> bool:
    """Whether a discrete signal changed over the step that was accepted last, or a unit has handled events."""
    return _handle_events(system, time) or any(s.value != s.old_value for s in system.discrete)


def _handle_events(system: System, time: float) -> bool:
    """Have units with event mode handle what is due at the communication point; whether anything was."""
    handled = [i for i in system.eventful if system.units[i].instance.handle_events()]
    for i in handled:
        system.units[i].get(time)
        system.read(i)
        for s in system.out[i]:
            s.value, s.rate = s.end_value, s.end_rate
    return bool(handled)
