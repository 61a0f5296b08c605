/* Messages of an instance: what was refused, which value it had and what was expected. */
#ifndef TOWAGE_MESSAGE_H
#define TOWAGE_MESSAGE_H

#include "instance.h"

typedef char Number[32];

const char *shortest(double value, Number text); /* as Python's repr: the shortest that reads back */
const char *phase_name(Phase);

/* Write the message and return the outcome; `explain` puts its text in front of the message that is there. */
Outcome refuse(Instance *, Outcome, const char *format, ...);
Outcome explain(Instance *, Outcome, const char *format, ...);

/* DONE, or a refusal: another phase, a value reference that no variable has. */
Outcome expect(Instance *, Phase, const char *what);
Outcome known_reference(Instance *, unsigned reference);

#endif
