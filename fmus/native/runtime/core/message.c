/* Messages: what was refused, which value it had and what was expected, in the words of fmus/python/instance.py. */
#include "message.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *phase_name(Phase phase)
{
    static const char *const names[] = PHASE_NAMES;
    return names[phase];
}

Outcome refuse(Instance *it, Outcome outcome, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(it->message, sizeof it->message, format, arguments);
    va_end(arguments);
    return outcome;
}

Outcome explain(Instance *it, Outcome outcome, const char *format, ...)
{
    char reason[sizeof it->message];
    va_list arguments;
    memcpy(reason, it->message, sizeof reason);
    va_start(arguments, format);
    const int used = vsnprintf(it->message, sizeof it->message, format, arguments);
    va_end(arguments);
    if (used >= 0 && (size_t)used < sizeof it->message)
        snprintf(it->message + used, sizeof it->message - (size_t)used, "%s", reason);
    return outcome;
}

const char *shortest(double value, Number text)
{
    if (!is_finite(value)) { /* C libraries differ here, and in the sign of a NaN */
        strcpy(text, isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf");
        return text;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof(Number), "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    if (text[strspn(text, "-0123456789")] == '\0') strcat(text, ".0");
    return text;
}

Outcome expect(Instance *it, Phase phase, const char *what)
{
    if (it->phase == phase) return DONE;
    return refuse(it, REFUSED, "%s in phase %s, expected phase %s", what, phase_name(it->phase), phase_name(phase));
}

Outcome known_reference(Instance *it, unsigned reference)
{
    const int count = it->unit->variables;
    if (reference < (unsigned)count) return DONE;
    return refuse(it, REFUSED, "no variable has value reference %u, they are 0 to %d", reference, count - 1);
}
